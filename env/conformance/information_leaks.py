"""Checks that a UAV's choices depend only on what it may know: not on unseen cells or teammates out of contact.

All follow one law. A pilot is a function of its briefing and of the views that it has been given. So, when anything
else is changed, a UAV whose views have been the same up to a step must choose the same at that step.
"""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.conformance.causes import shared_things
from indoor_explorers.env.conformance.findings import CannotFly, Differs, Violation
from indoor_explorers.env.conformance.flying import Changed, is_privileged
from indoor_explorers.env.conformance.harness import FIRST, SOLO, TEAM, Harness
from indoor_explorers.env.conformance.traces import Setup, Trace, compare
from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.sources import MapSource, OfficeMap, ThesisMaps
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.world import World

#: Steps up to which unseen cells are changed.
MOMENTS = (1, 5, 15, 30)
#: False sources of maps in the briefings.
TOLD: tuple[MapSource, ...] = (OfficeMap(), ThesisMaps(obstacles=0), ThesisMaps(obstacles=60, obstacle_size=(1, 1)))
#: How to fix a policy that depends on that.
DECLARE = "read briefing.generator alone and declare uses_generator = True, or do without briefing.scenario.map"
#: The team without any radio.
SILENT = TEAM.with_settings({"radio.model": "none"})
#: The UAVs whose actions are replaced.
REPLACED = (Changed(0, wanders=False), Changed(3, wanders=True))


def check_unseen(harness: Harness) -> str:
    """Change cells that no UAV has seen: while a UAV sees the same, it must choose the same."""
    if is_privileged(harness.policy):
        return "not checked: the policy is privileged and knows the true map"
    changes = decisions = 0
    for scenario, trace in zip((SOLO, TEAM), harness.alone, strict=True):
        for step in MOMENTS:
            setup = changed_where_unseen(scenario, trace, step) if step < len(trace.steps) else None
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


def changed_where_unseen(scenario: Scenario, trace: Trace, step: int) -> Setup | None:
    """Return the trace's start with half of the cells changed that are unseen at ``step``; None when there is none."""
    world = World(scenario)
    world.begin(0, trace.setup.seed, floorplan=trace.setup.floorplan, spawns=trace.setup.spawns)
    plan = world.floorplan(0)
    spawns = tuple((int(row), int(col)) for row, col in world.state.cell[0])
    unseen = np.frombuffer(trace.unseen[step], np.bool_).reshape(plan.shape)
    flip = unseen & (np.random.default_rng(step).random(plan.shape) < 0.5)
    truth = np.where(flip, np.where(plan.truth == FREE, OCCUPIED, FREE), plan.truth).astype(np.uint8)
    return Setup(trace.setup.seed, Floorplan(truth, "changed where unseen"), spawns) if flip.any() else None


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
                raise Violation(
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
    """Replace one UAV's actions: while another UAV neither sees nor hears of it, that one must choose the same."""
    decisions = 0
    (silent,) = harness.fly(SILENT, [FIRST])
    for scenario, recorded in ((SILENT, silent), (TEAM, harness.alone[1])):
        for changed in REPLACED:
            (again,) = harness.fly(scenario, [FIRST], changed=changed)
            found = compare(again, recorded, [n for n in range(scenario.team) if n != changed.agent])
            decisions += found.compared
            if found.differs is not None:
                agent, step = found.differs
                fix = "let pilots share nothing but messages, no list, dict or counter of the class, module or policy"
                fix += ", and in a batched act let no row look at another" if harness.batched else ""
                raise Differs(
                    f"UAV {agent} chose differently at step {step} when only UAV {changed.agent} acted differently, of "
                    f"which it had seen and heard nothing (radio {scenario.radio.model})",
                    fix + shared_things(harness.policy, harness.pilot),
                )
    return f"{2 * len(REPLACED)} teammates replaced, {decisions} decisions: changed nothing"
