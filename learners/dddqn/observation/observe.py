"""The network's observation, computed only from the UAV's own belief and from what it received by radio.

``scene`` (S,) uint8, 255 standing for 1, is an image of the surroundings
(:mod:`indoor_explorers.learners.dddqn.observation.map_image`). ``moves`` (4, F) float32 tells for each move whether it
is blocked and, if enabled, planner features
(:mod:`indoor_explorers.learners.dddqn.observation.view_gain`,
:mod:`indoor_explorers.learners.dddqn.observation.candidates`, :mod:`indoor_explorers.learners.dddqn.observation.tours`)
and the visits of the next cell since the last gain. :mod:`indoor_explorers.learners.dddqn.observation.layout` defines
the order of the numbers.

Lengths are measured in lidar ranges, so the observation has the same size and similar values for any map and lidar.
Rotating or mirroring the world permutes the numbers, with small differences in the map prior, which is learned, and in
tours, whose search breaks ties in a fixed order.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from indoor_explorers.env.grid.cells import FREE, MOVES
from indoor_explorers.env.grid.compiled import inner, kernel, leaf
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.search.bitsets import STRIDE
from indoor_explorers.learners.dddqn.observation.candidates import (
    CandidateScratch,
    look_for_candidates,
    new_candidate_scratch,
)
from indoor_explorers.learners.dddqn.observation.changed_boxes import note
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.known import Known
from indoor_explorers.learners.dddqn.observation.layout import ObservationLayout, observation_layout
from indoor_explorers.learners.dddqn.observation.map_image import VISIT_CAP, tabulate, write_map_image
from indoor_explorers.learners.dddqn.observation.map_prior import MapPrior, write_chances
from indoor_explorers.learners.dddqn.observation.memory import SPENT, ObservationMemory
from indoor_explorers.learners.dddqn.observation.optimistic_map import assume_obstacles
from indoor_explorers.learners.dddqn.observation.scales import Scratch, Sensor, scratch, sensor
from indoor_explorers.learners.dddqn.observation.tours import TourScratch, look_for_tours, new_tour_scratch
from indoor_explorers.learners.dddqn.observation.view_gain import (
    AROUND,
    flood_gains,
    forget_gains,
    gain_at,
    write_gains,
)
from indoor_explorers.learners.guard import discovered
from indoor_explorers.planners.toolbox.information.optimistic_views import update_views

#: A contested cell counts as blocked for (PATIENCE + the UAV's number) * min(encounters, GROWTH) observations.
PATIENCE, GROWTH = 2, 3


class ObservationContext(NamedTuple):
    """Constants and working arrays of observations on maps of one shape."""

    layout: ObservationLayout
    sensor: Sensor
    scratch: Scratch
    tours: TourScratch
    candidates: CandidateScratch
    prior: MapPrior


def observation_context(
    config: ObservationConfig, shape: tuple[int, int], scenario: Scenario, prior: MapPrior
) -> ObservationContext:
    """Return the context of observations on (H, W) maps of a scenario."""
    lidar = sensor(scenario.lidar.range)
    tours = new_tour_scratch(shape, scenario, config.tour_width)
    return ObservationContext(
        observation_layout(config), lidar, scratch(shape, lidar), tours, new_candidate_scratch(shape), prior
    )


@leaf(entry=False)
def _remember(
    belief: np.ndarray, row: int, col: int, sensor: Sensor, scratch: Scratch, memory: ObservationMemory, i: int
) -> int:
    """Count the gain and the visit, and reset the visits after a gain; return the number of boxes of newly known cells.

    Only cells that the UAV's own lidar discovered are a gain.
    """
    noted, visits = memory.noted[i], memory.visits[i]
    gain = discovered(belief, row, col, sensor.lidar, scratch.scan, noted)
    memory.gained[i] += gain
    memory.idle[i] = 0 if gain > 0 else memory.idle[i] + 1
    if gain > 0:
        visits[:] = 0
    visits[row, col] = min(visits[row, col] + 1, 255)
    return note(belief, noted, scratch.boxes)


@inner()
def _give_way(memory: ObservationMemory, i: int, row: int, col: int, agent: int) -> None:
    """Mark the target of a move that a teammate blocked as blocked for some observations.

    The time grows with each encounter and with the UAV's number, so that two UAVs that meet do not mirror each other's
    moves for ever.
    """
    memory.looks[i] += 1
    memory.pushes[i] = 0 if memory.idle[i] == 0 else memory.pushes[i]
    width = memory.barred.shape[2]
    if memory.aimed[i] >= 0 and memory.aimed[i] != row * width + col:
        memory.pushes[i] += 1
        r, c = divmod(memory.aimed[i], width)
        memory.barred[i, r, c] = memory.looks[i] + (PATIENCE + agent) * min(memory.pushes[i], GROWTH)


@inner()
def _write_moves(
    belief: np.ndarray,
    row: int,
    col: int,
    memory: ObservationMemory,
    i: int,
    context: ObservationContext,
    out: np.ndarray,
) -> None:
    """Write the features of each move, except its tours and candidates."""
    layout = context.layout
    for k in range(4):
        r, c = row + MOVES[k, 0], col + MOVES[k, 1]
        out[k] = 0.0
        blocked = not (0 <= r < belief.shape[0] and 0 <= c < belief.shape[1] and belief[r, c] == FREE)
        blocked = blocked or memory.barred[i, r, c] > memory.looks[i]
        context.scratch.blocked[k] = out[k, 0] = blocked
        if layout.gains_at >= 0:
            if blocked:
                out[k, layout.gains_at + 1] = 1.0
            else:
                here = gain_at(belief, r, c, context.sensor, context.scratch, memory.gain[i], memory.weight[i])
                write_gains(k, here, context.sensor, context.scratch, out[k, layout.gains_at :])
        if layout.visits_at >= 0 and not blocked:
            out[k, layout.visits_at] = min(memory.visits[i, r, c], VISIT_CAP) / VISIT_CAP


@inner()
def _look_for_tours(
    known: Known, memory: ObservationMemory, i: int, context: ObservationContext, moves: np.ndarray
) -> None:
    """Write the tours of each move."""
    belief, chance, work = known.belief[i], memory.chance[i], context.scratch
    views, passages = memory.views[i], memory.passages[i]
    obstructed = assume_obstacles(belief, chance, work.layer)
    lidar, reach, stale = context.sensor.lidar, context.sensor.reach + 1, context.tours.stale
    update_views(work.layer, STRIDE, lidar, work.scan, reach, stale, memory.obstacles[i], views, passages)
    out = moves[:, context.layout.tours_at :]
    look_for_tours(known, memory, i, context.tours, obstructed, work.blocked, out)


@leaf(entry=False)
def _look_ahead(
    known: Known, memory: ObservationMemory, i: int, context: ObservationContext, moves: np.ndarray
) -> None:
    """Write the features of each move; the summed-area tables must be filled."""
    belief, row, col, layout = known.belief[i], known.cell[i, 0], known.cell[i, 1], context.layout
    gain, weight = memory.gain[i], memory.weight[i]
    memory.nearest[i] = flood_gains(belief, row, col, context.sensor, context.scratch, gain, weight)
    _write_moves(belief, row, col, memory, i, context, moves)
    if layout.prospects_at >= 0:
        out = moves[:, layout.prospects_at :]
        look_for_candidates(known, memory, i, context.sensor, context.scratch, context.candidates, out)
    if layout.tours_at >= 0 and memory.views.shape[1] > 0:
        _look_for_tours(known, memory, i, context, moves)


@leaf(entry=False)
def _observe(
    known: Known,
    memory: ObservationMemory,
    i: int,
    context: ObservationContext,
    scene: np.ndarray,
    moves: np.ndarray,
) -> None:
    belief, row, col = known.belief[i], known.cell[i, 0], known.cell[i, 1]
    for n in range(_remember(belief, row, col, context.sensor, context.scratch, memory, i)):
        box = context.scratch.boxes[n]
        write_chances(belief, context.prior, context.scratch.patch, box, memory.chance[i])
        forget_gains(memory.gain[i], box, context.sensor.reach + AROUND)
    memory.gain[i, row, col] = SPENT
    _give_way(memory, i, row, col, known.agent[i])
    tabulate(belief, context.scratch.unknown, context.scratch.free)
    write_map_image(known, memory, i, context.sensor, context.scratch, context.layout, scene)
    _look_ahead(known, memory, i, context, moves)


@kernel()
def observe(
    known: Known,
    memory: ObservationMemory,
    columns: np.ndarray,
    context: ObservationContext,
    scene: np.ndarray,
    moves: np.ndarray,
) -> None:
    """Update the memory and compute the observations of some ``columns`` (K,) of C UAVs on maps of one shape.

    Fills these columns of ``scene`` (C, S) uint8 and ``moves`` (C, 4, F) float32. Call it once per step.
    """
    for i in columns:
        _observe(known, memory, i, context, scene[i], moves[i])
