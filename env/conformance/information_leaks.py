"""Checks that a UAV's choices depend only on what it may know: not on unseen cells or teammates out of contact.

A pilot is a function of its briefing and of its views so far. So, when anything else is changed, a UAV whose views have
been the same up to a step must choose the same at that step.

A policy that derives the seed from its random generator, and the true map from that, still passes this test.
:func:`check_seed` detects it by its results: generators and maps of different seeds are paired in every way, and the
pairing of equal seeds must not be better than the others.
"""

from __future__ import annotations

from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.conformance.findings import CannotFly, Differs, shared_state
from indoor_explorers.env.conformance.flying import Changed, is_privileged
from indoor_explorers.env.conformance.harness import FIRST, SOLO, STEPS, TEAM, Harness
from indoor_explorers.env.conformance.traces import Setup, Trace, compare
from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.sources import MapSource, OfficeMap, ThesisMaps
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.spawns import draw_floorplan, draw_spawns
from indoor_explorers.env.simulation.world import World

#: Steps up to which unseen cells are changed.
MOMENTS = (1, 5, 15, 30)
#: Seeds whose generators and maps are paired in every way.
SEEDS = range(11, 18)
#: The highest p-value at which a policy is reported to know the map of its seed.
SIGNIFICANT = 1e-3
#: False sources of maps in the briefings.
TOLD: tuple[MapSource, ...] = (OfficeMap(), ThesisMaps(obstacles=0), ThesisMaps(obstacles=60, obstacle_size=(1, 1)))
#: How to fix a policy that depends on the source of maps.
DECLARE = "read briefing.generator alone and declare uses_generator = True, or do without briefing.scenario.map"
#: The team without radio contact between UAVs, and with a home base that reaches the neighbouring cells.
SILENT = TEAM.with_settings({"radio.model": "none", "base.at": "start"})
#: The team of which two UAVs stop.
STOPPING = TEAM.with_settings({"failures.stops": ((0, 10), (2, 25))})
#: One UAV with an outdated prior map.
INFORMED = SOLO.with_settings({"prior.kind": "outdated"})
#: The UAVs whose actions are replaced: one that leaves and one that wanders.
LEAVES, WANDERS = Changed(0, wanders=False), Changed(3, wanders=True)


def check_unseen(harness: Harness) -> str:
    """Change cells that no UAV has seen: while a UAV sees the same, it must choose the same.

    The prior map of the unchanged map stays in the briefing.
    """
    if is_privileged(harness.policy):
        return "not checked: the policy is privileged and knows the true map"
    changes = decisions = 0
    flown = [*zip((SOLO, TEAM), harness.alone, strict=True), *_informed(harness)]
    for scenario, trace in flown:
        for step in MOMENTS:
            setup = changed_where_unseen(harness.sized(scenario), trace, step) if step < len(trace.steps) else None
            if setup is None:
                continue
            (again,) = harness.fly(scenario, [setup], step + 1)
            found = compare(again, trace, range(scenario.team))
            changes, decisions = changes + 1, decisions + found.compared
            if found.differs is not None:
                agent, when = found.differs
                raise Differs(
                    f"UAV {agent} chose differently at step {when} when only cells that no UAV had seen were changed",
                    "use the view and the briefing only, never the world or the scenario's map source",
                )
    return f"{changes} changes of unseen cells, {decisions} decisions: changed nothing"


def _informed(harness: Harness) -> list[tuple[Scenario, Trace]]:
    """Return the episode of one UAV with a prior map, if the prior map changes its choices."""
    (informed,) = harness.fly(INFORMED, [FIRST])
    return [] if compare(informed, harness.alone[0], [0]).differs is None else [(INFORMED, informed)]


def changed_where_unseen(scenario: Scenario, trace: Trace, step: int) -> Setup | None:
    """Return the trace's start with half of the cells changed that are unseen at ``step``; None when there is none."""
    world = World(scenario)
    world.begin(0, trace.setup.seed, floorplan=trace.setup.floorplan, spawns=trace.setup.spawns)
    plan = world.floorplan(0)
    spawns = tuple((int(row), int(col)) for row, col in world.state.cell[0])
    unseen = np.frombuffer(trace.unseen[step], np.bool_).reshape(plan.shape)
    flip = unseen & (np.random.default_rng(step).random(plan.shape) < 0.5)
    truth = np.where(flip, np.where(plan.truth == FREE, OCCUPIED, FREE), plan.truth).astype(np.uint8)
    plan = Floorplan(truth, "changed where unseen")
    return Setup(trace.setup.seed, plan, spawns, world.prior(0)) if flip.any() else None


def check_seed(harness: Harness) -> str:
    """Pair generators with maps of other seeds: a policy must not explore better on the map of its generator's seed."""
    if is_privileged(harness.policy):
        return "not checked: the policy is privileged and knows the true map"
    maps = [_on_own_map(harness.sized(SOLO), seed) for seed in SEEDS]
    explored = np.zeros((len(maps), len(maps)), np.int64)
    for shift in range(len(maps)):
        seen = _explored_by(harness, [setup._replace(seed=SEEDS[n - shift]) for n, setup in enumerate(maps)], maps)
        if shift and sum(seen) >= np.trace(explored):
            return f"{len(maps)} maps, {shift + 1} generators on each: no better on the map of the same seed"
        for n, cells in enumerate(seen):
            explored[n - shift, n] = cells
    chance = matching_chance(explored)
    if chance <= SIGNIFICANT:
        raise Differs(
            f"explores better on the map of its generator's seed than on maps of other seeds (p = {chance:.1g})",
            "draw numbers from briefing.rng and do nothing else with it, above all never make the map of its seed",
        )
    return f"{len(maps)} maps and generators, all pairs: hardly better on the map of the same seed (p = {chance:.2g})"


def _on_own_map(scenario: Scenario, seed: int) -> Setup:
    """Return the start on a seed's own map, which stays when the seed is replaced."""
    plan = draw_floorplan(scenario, seed)
    return Setup(seed, plan, tuple(draw_spawns(scenario, plan, seed)))


def _explored_by(harness: Harness, setups: list[Setup], own: list[Setup]) -> list[int]:
    """Return the number of cells seen in each episode, summed over the steps; ``own`` has the seeds of the maps."""
    try:
        traces = harness.fly(SOLO, setups)
    except CannotFly as error:
        if setups == own:
            raise
        raise Differs(
            f"the policy fails on a map that is not the one of its generator's seed ({error.found})",
            "draw numbers from briefing.rng and do nothing else with it",
        ) from error
    seen = [[unseen.count(0) for unseen in trace.unseen] for trace in traces]
    return [sum(each) + (STEPS - len(each)) * each[-1] for each in seen]  # it stays as it was after an episode's end


def matching_chance(explored: NDArray[np.int64]) -> float:
    """Return the p-value of the sum of the diagonal of a matrix (K, K) among those of all permutations of its rows."""
    orders = np.array(list(permutations(range(len(explored)))))
    sums = explored[orders, np.arange(len(explored))].sum(axis=1)
    return float(np.mean(sums >= np.trace(explored)))


def check_generator(harness: Harness) -> str:
    """Give a false source of maps in the briefing: a policy that does not declare its use must choose the same."""
    if harness.policy.uses_generator:
        return "not checked: the policy declares that it uses the generator's settings"
    decisions = 0
    for scenario, trace in zip((SOLO, TEAM), harness.alone, strict=True):
        for maps in TOLD:
            try:
                (again,) = harness.fly(scenario, [trace.setup], told=maps)
            except CannotFly as error:
                raise Differs(
                    f"the policy fails when its briefing describes other maps ({error.found})", DECLARE
                ) from error
            found = compare(again, trace, range(scenario.team))
            decisions += found.compared
            if found.differs is not None:
                agent, step = found.differs
                raise Differs(
                    f"UAV {agent} chose differently at step {step} when its briefing described other maps", DECLARE
                )
    return f"{len(TOLD)} false descriptions of the maps, {decisions} decisions: changed nothing"


def check_unlinked(harness: Harness) -> str:
    """Replace one UAV's actions, or let UAVs stop: another one must choose the same until it sees or hears of this.

    A stop is observable only as radio silence; a UAV does not know in advance that it will stop.
    """
    (silent,) = harness.fly(SILENT, [FIRST])
    team, decisions = harness.alone[1], 0
    for scenario, recorded, changed in (
        (SILENT, silent, LEAVES),
        (SILENT, silent, WANDERS),
        (TEAM, team, WANDERS),
        (STOPPING, team, None),
    ):
        (again,) = harness.fly(scenario, [FIRST], changed=changed)
        others = [n for n in range(scenario.team) if changed is None or n != changed.agent]
        found = compare(again, recorded, others)
        decisions += found.compared
        if found.differs is not None:
            agent, step = found.differs
            fix = "let pilots share nothing but messages, no list, dict or counter of the class, module or policy"
            fix += ", and in a batched act let no row look at another" if harness.batched else ""
            what = "teammates stopped" if changed is None else f"UAV {changed.agent} acted differently"
            raise Differs(
                f"UAV {agent} chose differently at step {step} when only {what}, of which it had seen and heard "
                f"nothing (radio {scenario.radio.model})",
                fix + shared_state(harness.policy, harness.pilot),
            )
    return f"3 teammates replaced and 2 stopped, {decisions} decisions: changed nothing"
