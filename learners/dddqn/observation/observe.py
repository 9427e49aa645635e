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
    new_candidate_scratch,
    write_candidates,
)
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import ObservationLayout, observation_layout
from indoor_explorers.learners.dddqn.observation.map_image import VISIT_CAP, tabulate, write_map_image
from indoor_explorers.learners.dddqn.observation.map_prior import MapPrior, assume_obstacles, write_chances
from indoor_explorers.learners.dddqn.observation.memory import SPENT, ObservationMemory, note
from indoor_explorers.learners.dddqn.observation.scales import Scratch, Sensor, scratch, sensor
from indoor_explorers.learners.dddqn.observation.tours import TourScratch, new_tour_scratch, write_tours
from indoor_explorers.learners.dddqn.observation.uav import Known, Uav, uav_of
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
    tours = new_tour_scratch(shape, scenario, config.tour_width, division=config.division)
    return ObservationContext(
        observation_layout(config), lidar, scratch(shape, lidar), tours, new_candidate_scratch(shape), prior
    )


@leaf(entry=False)
def _remember(uav: Uav, context: ObservationContext) -> None:
    """Count the gain and the visit, reset the visits after a gain, and update all that depends on newly known cells.

    Only cells that the UAV's own lidar discovered are a gain.
    """
    lidar, work = context.sensor, context.scratch
    gain = discovered(uav.belief, uav.row, uav.col, lidar.lidar, work.scan, uav.noted)
    uav.gained[0] += gain
    uav.idle[0] = 0 if gain > 0 else uav.idle[0] + 1
    if gain > 0:
        uav.visits[:] = 0
    uav.visits[uav.row, uav.col] = min(uav.visits[uav.row, uav.col] + 1, 255)
    for n in range(note(uav.belief, uav.noted, work.boxes)):
        write_chances(uav.belief, context.prior, work.patch, work.boxes[n], uav.chance)
        forget_gains(uav.gain, work.boxes[n], lidar.reach + AROUND)
    uav.gain[uav.row, uav.col] = SPENT


@inner()
def _give_way(uav: Uav) -> None:
    """Mark the target of a move that a teammate blocked as blocked for some observations.

    The time grows with each encounter and with the UAV's number, so that two UAVs that meet do not mirror each other's
    moves for ever.
    """
    uav.looks[0] += 1
    uav.pushes[0] = 0 if uav.idle[0] == 0 else uav.pushes[0]
    width = uav.barred.shape[1]
    if uav.aimed[0] >= 0 and uav.aimed[0] != uav.row * width + uav.col:
        uav.pushes[0] += 1
        r, c = divmod(uav.aimed[0], width)
        uav.barred[r, c] = uav.looks[0] + (PATIENCE + uav.agent) * min(uav.pushes[0], GROWTH)


@leaf(entry=False)
def _write_moves(uav: Uav, context: ObservationContext, out: np.ndarray) -> None:
    """Write the features of each move, except its tours and candidates."""
    layout, belief = context.layout, uav.belief
    uav.nearest[0] = flood_gains(belief, uav.row, uav.col, context.sensor, context.scratch, uav.gain, uav.weight)
    for k in range(4):
        r, c = uav.row + MOVES[k, 0], uav.col + MOVES[k, 1]
        out[k] = 0.0
        blocked = not (0 <= r < belief.shape[0] and 0 <= c < belief.shape[1] and belief[r, c] == FREE)
        blocked = blocked or uav.barred[r, c] > uav.looks[0]
        context.scratch.blocked[k] = out[k, 0] = blocked
        if layout.gains_at >= 0:
            if blocked:
                out[k, layout.gains_at + 1] = 1.0
            else:
                here = gain_at(belief, r, c, context.sensor, context.scratch, uav.gain, uav.weight)
                write_gains(k, here, context.sensor, context.scratch, out[k, layout.gains_at :])
        if layout.visits_at >= 0 and not blocked:
            out[k, layout.visits_at] = min(uav.visits[r, c], VISIT_CAP) / VISIT_CAP


@leaf(entry=False)
def _write_tours(uav: Uav, context: ObservationContext, moves: np.ndarray) -> None:
    """Write the tours behind each move."""
    work, lidar = context.scratch, context.sensor
    obstructed = assume_obstacles(uav.belief, uav.chance, work.layer)
    stale, reach = context.tours.stale, lidar.reach + 1
    update_views(work.layer, STRIDE, lidar.lidar, work.scan, reach, stale, uav.obstacles, uav.views, uav.passages)
    write_tours(uav, context.tours, obstructed, work.blocked, moves[:, context.layout.tours_at :])


@leaf(entry=False)
def _observe(
    known: Known, memory: ObservationMemory, i: int, context: ObservationContext, scene: np.ndarray, moves: np.ndarray
) -> None:
    """Update the memory and compute the observation of UAV ``i``; each stage needs those before it."""
    uav, layout, work = uav_of(known, memory, i), context.layout, context.scratch
    _remember(uav, context)
    _give_way(uav)
    tabulate(uav.belief, work.unknown, work.free)
    write_map_image(uav, context.sensor, work, layout, scene)
    _write_moves(uav, context, moves)
    if layout.prospects_at >= 0:
        write_candidates(uav, context.sensor, work, context.candidates, moves[:, layout.prospects_at :])
    if layout.tours_at >= 0 and uav.views.shape[0] > 0:
        _write_tours(uav, context, moves)


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
