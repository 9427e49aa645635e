"""What the network sees of one UAV, computed from its own belief and what it heard alone.

``scene`` (S,) uint8, 255 standing for 1, is a picture of the surroundings
(:mod:`indoor_explorers.learners.dddqn.observation.map_image`). ``moves`` (4, F) float32 says of each move whether it is
blocked and, as switched on, what planners would see behind it
(:mod:`indoor_explorers.learners.dddqn.observation.view_gain`,
:mod:`indoor_explorers.learners.dddqn.observation.candidates`, :mod:`indoor_explorers.learners.dddqn.observation.tours`)
and how often the next cell was visited since the last gain. :mod:`indoor_explorers.learners.dddqn.observation.layout`
tells where everything is.

Everything is measured in lidar ranges, so the input has the same size and about the same meaning for any map and
lidar. Rotating or mirroring the world permutes the numbers; only chances, which were learned from examples, and tours,
a search that breaks ties in a fixed order, then differ a little.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from indoor_explorers.env.grid.cells import FREE, MOVES
from indoor_explorers.env.grid.compiled import inner, kernel, leaf
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.search.bitsets import STRIDE
from indoor_explorers.env.search.optimistic_views import update_views
from indoor_explorers.learners.dddqn.observation.candidates import Outlook, look_for_prospects, new_outlook
from indoor_explorers.learners.dddqn.observation.changed_boxes import note
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import Layout, layout
from indoor_explorers.learners.dddqn.observation.map_image import VISIT_CAP, tabulate, write_scene
from indoor_explorers.learners.dddqn.observation.map_prior import MapPrior, write_chances
from indoor_explorers.learners.dddqn.observation.memory import Memory
from indoor_explorers.learners.dddqn.observation.optimistic_map import assume_obstacles
from indoor_explorers.learners.dddqn.observation.scales import Scratch, Sensor, scratch, sensor
from indoor_explorers.learners.dddqn.observation.tours import Planner, look_for_tours, new_planner
from indoor_explorers.learners.dddqn.observation.view_gain import (
    AROUND,
    SPENT,
    forget_gains,
    gain_at,
    survey,
    write_gains,
)
from indoor_explorers.learners.guard import discovered

#: Looks for which UAV 0 takes a way for blocked that a teammate was in, and times that the wait still grows.
PATIENCE, GROWTH = 2, 3


class Eyes(NamedTuple):
    """Everything that observing on maps of one shape needs besides the UAV's own state."""

    plan: Layout
    sensor: Sensor
    scratch: Scratch
    planner: Planner
    outlook: Outlook
    prior: MapPrior


class Known(NamedTuple):
    """What C UAVs know, of up to M teammates each."""

    belief: np.ndarray
    """(C, H, W) uint8, read-only as in a pilot's view, lest everything is compiled twice."""
    cell: np.ndarray
    """(C, 2) int64."""
    mates: np.ndarray
    """(C, M, 2) int64: where each UAV of the team was last heard."""
    ages: np.ndarray
    """(C, M) int64: how many steps ago, -1 for never and for itself."""
    facts: np.ndarray
    """(C, 2) float64: the UAV's number in its team, and the share of its steps that are flown."""


def eyes(config: ObservationConfig, shape: tuple[int, int], scenario: Scenario, prior: MapPrior) -> Eyes:
    """Prepare to observe on (H, W) maps of a scenario."""
    lidar = sensor(scenario.lidar.range)
    planner = new_planner(shape, scenario, config.tour_width)
    return Eyes(layout(config), lidar, scratch(shape, lidar), planner, new_outlook(shape), prior)


@leaf()
def _remember(belief: np.ndarray, row: int, col: int, sensor: Sensor, scratch: Scratch, memory: Memory, i: int) -> int:
    """Count a visit, forgetting all of them after a gain of its own; return how many boxes hold what became known."""
    noted, visits = memory.noted[i], memory.visits[i]
    gain = discovered(belief, row, col, sensor.lidar, scratch.scan, noted)
    memory.gained[i] += gain
    memory.idle[i] = 0 if gain > 0 else memory.idle[i] + 1
    if gain > 0:
        visits[:] = 0
    visits[row, col] = min(visits[row, col] + 1, 255)
    return note(belief, noted, scratch.boxes)


@inner()
def _give_way(memory: Memory, i: int, row: int, col: int, agent: int) -> None:
    """Bar the way that a teammate was in for some looks: longer each time, and longer for higher numbers.

    So two that met do not mirror each other's moves for good.
    """
    memory.looks[i] += 1
    memory.pushes[i] = 0 if memory.idle[i] == 0 else memory.pushes[i]
    width = memory.barred.shape[2]
    if memory.aimed[i] >= 0 and memory.aimed[i] != row * width + col:
        memory.pushes[i] += 1
        r, c = divmod(memory.aimed[i], width)
        memory.barred[i, r, c] = memory.looks[i] + (PATIENCE + agent) * min(memory.pushes[i], GROWTH)


@inner()
def _write_moves(belief: np.ndarray, row: int, col: int, memory: Memory, i: int, eyes: Eyes, out: np.ndarray) -> None:
    """Write what is known of each move but for its tours and prospects."""
    plan = eyes.plan
    for k in range(4):
        r, c = row + MOVES[k, 0], col + MOVES[k, 1]
        out[k] = 0.0
        blocked = not (0 <= r < belief.shape[0] and 0 <= c < belief.shape[1] and belief[r, c] == FREE)
        blocked = blocked or memory.barred[i, r, c] > memory.looks[i]
        eyes.scratch.blocked[k] = out[k, 0] = blocked
        if plan.gains_at >= 0:
            if blocked:
                out[k, plan.gains_at + 1] = 1.0
            else:
                here = gain_at(belief, r, c, eyes.sensor, eyes.scratch, memory.gain[i], memory.weight[i])
                write_gains(k, here, eyes.sensor, eyes.scratch, out[k, plan.gains_at :])
        if plan.visits_at >= 0 and not blocked:
            out[k, plan.visits_at] = min(memory.visits[i, r, c], VISIT_CAP) / VISIT_CAP


@inner()
def _look_for_tours(known: Known, memory: Memory, i: int, eyes: Eyes, moves: np.ndarray) -> None:
    """Write the tours of each move."""
    belief, chance, work = known.belief[i], memory.chance[i], eyes.scratch
    views, passages = memory.views[i], memory.passages[i]
    obstructed = assume_obstacles(belief, chance, work.layer)
    lidar, reach, stale = eyes.sensor.lidar, eyes.sensor.reach + 1, eyes.planner.stale
    update_views(work.layer, STRIDE, lidar, work.scan, reach, stale, memory.obstacles[i], views, passages)
    look_for_tours(
        belief,
        known.cell[i],
        int(known.facts[i, 0]),
        known.mates[i],
        known.ages[i],
        chance,
        views,
        passages,
        memory.tour[i],
        eyes.planner,
        obstructed,
        work.blocked,
        moves[:, eyes.plan.tours_at :],
    )


@inner(inlined=False)
def _look_ahead(known: Known, memory: Memory, i: int, eyes: Eyes, moves: np.ndarray) -> None:
    """Write what lies behind each move; the summed-area tables must be filled."""
    belief, row, col, plan = known.belief[i], known.cell[i, 0], known.cell[i, 1], eyes.plan
    gain, weight = memory.gain[i], memory.weight[i]
    memory.nearest[i] = survey(belief, row, col, eyes.sensor, eyes.scratch, gain, weight)
    _write_moves(belief, row, col, memory, i, eyes, moves)
    if plan.prospects_at >= 0:
        look_for_prospects(
            belief,
            known.mates[i],
            known.ages[i],
            gain,
            weight,
            memory.prospect[i],
            eyes.sensor,
            eyes.scratch,
            eyes.outlook,
            moves[:, plan.prospects_at :],
        )
    if plan.tours_at >= 0 and memory.views.shape[1] > 0:
        _look_for_tours(known, memory, i, eyes, moves)


@inner(inlined=False)
def _observe(
    known: Known, memory: Memory, i: int, eyes: Eyes, facts: np.ndarray, scene: np.ndarray, moves: np.ndarray
) -> None:
    belief, row, col = known.belief[i], known.cell[i, 0], known.cell[i, 1]
    for n in range(_remember(belief, row, col, eyes.sensor, eyes.scratch, memory, i)):
        box = eyes.scratch.boxes[n]
        write_chances(belief, eyes.prior, eyes.scratch.patch, box, memory.chance[i])
        forget_gains(memory.gain[i], box, eyes.sensor.reach + AROUND)
    memory.gain[i, row, col] = SPENT
    _give_way(memory, i, row, col, int(known.facts[i, 0]))
    tabulate(belief, eyes.scratch.unknown, eyes.scratch.free)
    facts[0], facts[1], facts[2] = known.facts[i, 0], known.facts[i, 1], memory.idle[i]
    write_scene(
        belief,
        known.cell[i],
        known.mates[i],
        known.ages[i],
        memory.visits[i],
        memory.chance[i],
        facts,
        eyes.sensor,
        eyes.scratch,
        eyes.plan,
        scene,
    )
    _look_ahead(known, memory, i, eyes, moves)


@kernel()
def observe(
    known: Known, memory: Memory, columns: np.ndarray, eyes: Eyes, scene: np.ndarray, moves: np.ndarray
) -> None:
    """Remember and observe for some ``columns`` (K,) of C UAVs on maps of one shape.

    Fills those columns of ``scene`` (C, S) uint8 and ``moves`` (C, 4, F) float32.
    """
    facts = np.zeros(3)
    for i in columns:
        _observe(known, memory, i, eyes, facts, scene[i], moves[i])
