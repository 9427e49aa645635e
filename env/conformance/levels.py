"""Maps of several levels: what a policy does there, a report that fails only where the contract is broken."""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.conformance.findings import CannotFly, Warned
from indoor_explorers.env.conformance.flying import CheckedFlight
from indoor_explorers.env.conformance.harness import FIRST, STEPS, Harness, refuse_others
from indoor_explorers.env.scenarios.presets import PRESETS

#: Two UAVs in a small building of two storeys, three levels each.
STOREYS = PRESETS["small-storeys"].for_evaluation()


def check_levels(harness: Harness) -> str:
    """Fly two UAVs in a building of several levels, and report how many of these they fly on."""
    if harness.map_shape is not None:
        return "not flown: the policy's map_shape says that it flies maps of one size"
    known = harness.known_violations  # raises if the policy flies nowhere
    try:
        flight = CheckedFlight(harness.policy, STOREYS, [FIRST])
        starts = {tuple(cell) for cell in flight.world.state.cell[0].tolist()}
        (trace,) = flight.fly(STEPS)
    except CannotFly as error:
        return Warned(f"cannot fly maps of several levels: {error.found}")
    refuse_others([trace], known)
    world = flight.world
    levels, share = world.briefing(0, 0).levels, world.team_coverage.item(0)
    rows = np.flatnonzero(world.state.visited[0].any(axis=(0, 2)))
    flown = len({levels.voxel((row, 0))[0] for row in rows.tolist()})
    stay = flown == len({levels.voxel(cell)[0] for cell in starts})
    where = "staying on the levels of their starts" if stay else f"on {flown} of {levels.number} levels"
    return f"two UAVs know {share:.0%} of a building after {STEPS} steps, {where}"
