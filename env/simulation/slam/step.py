"""The step of a world whose sensors or poses err, compiled.

It equals :mod:`indoor_explorers.env.simulation.step` except for maps. Agents scan in every step, as each scan has new
errors. Moves, collisions, radio contacts and coverage are those of the true world; an agent's map and believed cell
follow from its scans and odometry.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import TURN
from indoor_explorers.env.grid.compiled import inner, kernel
from indoor_explorers.env.grid.randomness import Stream, draw, shuffled, stream_key
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.contacts import contacts_of
from indoor_explorers.env.simulation.engine import Engine
from indoor_explorers.env.simulation.slam.exchange import share
from indoor_explorers.env.simulation.slam.localisation import close_loop, count_errors, drift, meet_mates
from indoor_explorers.env.simulation.slam.maps import forget_lost, move_scan, place_agent
from indoor_explorers.env.simulation.slam.scans import read_scan
from indoor_explorers.env.simulation.slam.state import ErrorRules, Readings, Slam, SlamParts, error_rules_of
from indoor_explorers.env.simulation.state import End, State
from indoor_explorers.env.simulation.step import clear_step, finish_step, move, update_legal

FLYING = int(End.FLYING)
NOISE, DRIFT = int(Stream.NOISE), int(Stream.DRIFT)


@inner()
def _sense(parts: SlamParts, b: int, agent: int) -> None:
    """Make an agent's scan of this step and draw it into its map and the team's."""
    state, slam, readings = parts.state, parts.slam, parts.readings
    number, team = state.step[b], state.end.shape[1]
    row, col, width = state.cell[b, agent, 0], state.cell[b, agent, 1], state.truth.shape[2]
    slam.true_cell[b, agent, number] = row * width + col
    if slam.first_visit[b, agent, row, col] < 0:
        slam.first_visit[b, agent, row, col] = number
    pose = state.believed_cell[b, agent, 0] * width + state.believed_cell[b, agent, 1]
    count = read_scan(parts, b, agent, number)
    state.discovered[b, agent] += move_scan(parts, count, b, agent, agent, number, pose)
    move_scan(parts, count, b, team, agent, number, pose)
    for holder in (agent, team):
        slam.scans[b, holder, agent] = number + 1
    sensed, counts = state.sensed[b, agent].flat, state.counts[b].flat
    for k in range(count):
        cell = readings.cells[k]
        state.sensed_count[b, agent] += counts[cell] and not sensed[cell]
        sensed[cell] = True
    place_agent(state, slam, b, agent)


@inner()
def _act(parts: SlamParts, b: int, agent: int, action: int) -> None:
    """Carry out an agent's action in the true world, and log its odometry for the coming scan."""
    rules, state, slam, number = parts.rules, parts.state, parts.slam, parts.state.step[b] + 1
    heading, moved, bumps = slam.heading[b, agent, number - 1], False, state.collisions[b, agent]
    state.reward[b, agent] += rules.reward_step
    if action == TURN:
        heading = (heading + 1) % 4
    elif action < 4:
        heading, moved = action, move(rules, state, b, agent, action)
    slam.heading[b, agent, number] = heading
    slam.bump[b, agent, number] = action if state.collisions[b, agent] > bumps else -1
    slam.way[b, agent, number] = slam.way[b, agent, number - 1] + moved
    slam.variance[b, agent, number] = slam.variance[b, agent, number - 1] + parts.errors.drift * moved
    if moved:
        drift(parts.errors, state, slam, b, agent, action)


@inner()
def _stay_ended(slam: Slam, b: int, agent: int, number: int) -> None:
    """Keep the heading and the pose variance of an agent that has ended for its view."""
    slam.heading[b, agent, number] = slam.heading[b, agent, number - 1]
    slam.variance[b, agent, number] = slam.variance[b, agent, number - 1]


@inner()
def _share_scans(parts: SlamParts, b: int, linked: bool, based: bool) -> None:
    """Let linked agents correct each other's poses, and merge maps with each other and the base."""
    state = parts.state
    if linked and parts.errors.mates and parts.errors.drift > 0.0:
        meet_mates(parts, b)
    if linked or based:
        share(parts, b, based)
    for n in range(state.end.shape[1]):
        place_agent(state, parts.slam, b, n)
        update_legal(parts.rules, state, b, n, state.belief[b, n])


_contact, _fail_and_contact = contacts_of(_share_scans, forget_lost)


@kernel(entry=False)
def _new_readings(engine: Engine) -> Readings:
    height, width = engine.state.truth.shape[1], engine.state.truth.shape[2]
    room = 2 * engine.work.scan.cells.shape[0] + 2
    return Readings(
        np.empty(room, np.int64),
        np.empty(room, np.float32),
        np.zeros(height * width, np.int32),
        np.empty((height, width), np.uint8),
    )


@inner()
def _clear(slam: Slam, b: int, seed: int) -> None:
    """Reset what an episode has changed, and set its streams."""
    slam.log_odds[b, :, :, :] = 0.0
    slam.drawn_at[b, :, :, :] = -1
    slam.scans[b, :, :] = 0
    slam.revision[b, :, :] = 0
    slam.first_visit[b, :, :, :] = -1
    slam.listed[b, :, :, :] = False
    slam.shown_free[b, :] = -1
    slam.pose_error[b, :] = 0.0
    slam.noise_key[b], slam.drift_key[b] = stream_key(seed, NOISE, 0), stream_key(seed, DRIFT, 0)


@kernel()
def begin_uncertain(engine: Engine, errors: ErrorRules, slam: Slam, episodes: np.ndarray, seeds: np.ndarray) -> None:
    """Make the first scans and contacts of episodes (K,) that have just begun, with seeds (K,)."""
    state = engine.state
    parts = SlamParts(engine.rules, errors, state, slam, engine.lidar, engine.work, _new_readings(engine))
    for k in range(episodes.shape[0]):
        b = episodes[k]
        _clear(slam, b, seeds[k])
        for n in range(state.end.shape[1]):
            state.believed_cell[b, n, 0], state.believed_cell[b, n, 1] = state.cell[b, n, 0], state.cell[b, n, 1]
            slam.heading[b, n, 0] = draw(slam.noise_key[b], np.uint64(n)) % np.uint64(4)
            slam.bump[b, n, 0], slam.way[b, n, 0], slam.variance[b, n, 0] = -1, 0, 0.0
            _sense(parts, b, n)
        _contact(parts, b)


@kernel()
def advance_uncertain(
    engine: Engine, errors: ErrorRules, slam: Slam, actions: np.ndarray, first: int, last: int
) -> None:
    """Advance episodes first to last - 1 by one step where an agent flies; ``actions`` is (B, N)."""
    state, order = engine.state, engine.work.order
    parts = SlamParts(engine.rules, errors, state, slam, engine.lidar, engine.work, _new_readings(engine))
    for b in range(first, last):
        if not clear_step(state, b):
            continue
        shuffled(state.order_key[b], state.step[b], order)
        for k in range(state.end.shape[1]):
            if state.end[b, order[k]] == FLYING:
                _act(parts, b, order[k], actions[b, order[k]])
            else:
                _stay_ended(slam, b, order[k], state.step[b] + 1)
        state.step[b] += 1
        for n in range(state.end.shape[1]):
            if state.end[b, n] == FLYING:
                if errors.drift > 0.0:
                    close_loop(parts, b, n)
                _sense(parts, b, n)
        _fail_and_contact(parts, b)
        count_errors(state, parts.slam, b)
        finish_step(engine.rules, state, b)


class UncertainModel:
    """Begin and advance the episodes of a world whose sensors or poses err."""

    def __init__(self, scenario: Scenario, slam: Slam) -> None:
        self._errors = error_rules_of(scenario)
        self._slam = slam

    def begin(self, engine: Engine, state: State, episodes: Sequence[int], seeds: Sequence[int]) -> None:
        """Make the first scans and contacts of episodes that have just begun."""
        begun = np.array(episodes, np.int64), np.array(seeds, np.int64)
        begin_uncertain(engine, self._errors, self._slam, *begun)

    def advance(self, engine: Engine, state: State, actions: NDArray[np.int64], first: int, last: int) -> None:
        """Advance episodes first to last - 1 by one step with actions (B, N)."""
        advance_uncertain(engine, self._errors, self._slam, actions, first, last)
