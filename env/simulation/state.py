"""The state of a batch of episodes as plain arrays, and the rules as plain numbers.

Axes: B episodes, N agents, H rows, W columns. Compiled kernels read and write these; everything else
goes through :class:`indoor_explorers.env.simulation.world.World`.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.policies.view import MESSAGE_LIMIT
from indoor_explorers.env.scenarios.codes import RadioModel, StuckRule
from indoor_explorers.env.scenarios.scenario import LEAST_BUDGET, Scenario

#: A named tuple of arrays.
Arrays = TypeVar("Arrays", bound=tuple[NDArray[Any], ...])


class End(IntEnum):
    """Why an agent's episode ended; ``BUDGET`` is a truncation, all others are terminations."""

    FLYING = 0
    """It has not ended."""
    GOAL = 1
    """The goal coverage is reached."""
    COLLISION = 2
    """It flew into an obstacle."""
    OUT_OF_BOUNDS = 3
    """It flew off the map."""
    STUCK = 4
    """It went on without a discovery or between the same cells for too long, as the rule ``stuck`` says."""
    BUDGET = 5
    """All steps are flown."""
    STOPPED = 6
    """It failed, see :mod:`indoor_explorers.env.simulation.failures`."""


class Rules(NamedTuple):
    """A scenario's rules as numbers for compiled code."""

    end_on_collision: bool
    goal: float
    count_all_cells: bool
    """Whether coverage counts all cells of the map, not the reachable ones alone."""
    budget: int
    """Steps; 0 for one step per reachable cell."""
    least_budget: int
    exact_scans: bool
    """Whether the step itself scans; not where a plug-in does, or where sensors or poses err."""
    radio_model: int
    radio_range: float
    radio_exponent: float
    radio_wall_loss: float
    radio_loss: float
    goal_of_team: bool
    goal_of_every: bool
    """Whether the goal is that every flying agent's own map has the coverage."""
    stuck_rule: int
    stuck_repeats: int
    reward_step: float
    reward_discovered: float
    reward_received: float
    reward_collision: float
    reward_out_of_bounds: float
    reward_stuck: float
    reward_goal: float
    reward_stopped: float
    failures: bool
    """Whether UAVs or radios can fail."""
    hazard: float
    stop_step: NDArray[np.int64]
    """(N,) step in which each agent stops, 0 for none."""
    last_word: bool
    radio_hazard: float
    radio_outage: int
    base: bool
    """Whether there is a home base."""
    base_row: int
    """Its row; -1: it is where agent 0 starts."""
    base_col: int
    base_radius: float
    goal_of_base: bool
    """Whether the goal is what the base knows."""


def rules_of(scenario: Scenario) -> Rules:
    """Translate a scenario."""
    return Rules(
        end_on_collision=scenario.on_collision == "end",
        goal=scenario.goal,
        count_all_cells=scenario.denominator == "map",
        budget=scenario.budget or 0,
        least_budget=LEAST_BUDGET,
        exact_scans=scenario.lidar.custom is None and not scenario.uncertain,
        radio_model=RadioModel.CUSTOM if scenario.radio.custom is not None else RadioModel.named(scenario.radio.model),
        radio_range=scenario.radio.range,
        radio_exponent=scenario.radio.exponent,
        radio_wall_loss=scenario.radio.wall_loss,
        radio_loss=scenario.radio.loss,
        goal_of_team=scenario.goal_of == "team",
        goal_of_every=scenario.goal_of == "every" and not scenario.base.must_return,
        stuck_rule=StuckRule.named(scenario.stuck.rule),
        stuck_repeats=scenario.stuck.repeats,
        reward_step=scenario.rewards.step,
        reward_discovered=scenario.rewards.discovered,
        reward_received=scenario.rewards.received,
        reward_collision=scenario.rewards.collision,
        reward_out_of_bounds=scenario.rewards.out_of_bounds,
        reward_stuck=scenario.rewards.stuck,
        reward_goal=scenario.rewards.goal,
        reward_stopped=scenario.failures.reward,
        failures=scenario.failures.any,
        hazard=scenario.failures.hazard,
        stop_step=_stop_steps(scenario),
        last_word=scenario.failures.last_word,
        radio_hazard=scenario.failures.radio_hazard,
        radio_outage=scenario.failures.radio_outage,
        base=scenario.base.exists,
        base_row=-1 if isinstance(scenario.base.at, str) else scenario.base.at[0],
        base_col=-1 if isinstance(scenario.base.at, str) else scenario.base.at[1],
        base_radius=scenario.base.radius,
        goal_of_base=scenario.base.must_return,
    )


def _stop_steps(scenario: Scenario) -> NDArray[np.int64]:
    steps = np.zeros(scenario.team, np.int64)
    for agent, step in scenario.failures.stops:
        steps[agent] = step
    return steps


class State(NamedTuple):
    """The state of a batch of episodes."""

    truth: NDArray[np.uint8]
    """(B, H, W) 1 free, 2 occupied."""
    counts: NDArray[np.bool_]
    """(B, H, W) cells that coverage counts."""
    total: NDArray[np.int64]
    """(B,) number of those cells: the denominator."""
    needed: NDArray[np.int64]
    """(B,) number of those cells that must be known to reach the goal."""
    budget: NDArray[np.int64]
    """(B,) steps."""
    order_key: NDArray[np.uint64]
    """(B,) key of the stream that draws the order of moves."""
    radio_key: NDArray[np.uint64]
    fading: NDArray[np.float64]
    """(B, 2) K and X of the radio model ``path-loss-ir2``, in dB."""
    """(B,) key of the stream that draws which contacts fail."""
    failure_key: NDArray[np.uint64]
    """(B,) key of the stream that draws which UAVs and radios fail."""
    step: NDArray[np.int64]
    """(B,) steps flown."""
    end: NDArray[np.uint8]
    """(B, N) :class:`End`."""
    cell: NDArray[np.int64]
    """(B, N, 2) row and column."""
    believed_cell: NDArray[np.int64]
    """(B, N, 2) where each agent believes to be: the same array as ``cell`` where poses are certain."""
    legal: NDArray[np.bool_]
    """(B, N, 5) actions that end neither in a wall nor off the map."""
    belief: NDArray[np.uint8]
    """(B, N, H, W) 0 unknown, 1 free, 2 occupied."""
    sensed: NDArray[np.bool_]
    """(B, N, H, W) cells the agent's own lidar has seen."""
    visited: NDArray[np.bool_]
    """(B, N, H, W) cells the agent has been in."""
    union: NDArray[np.uint8]
    """(B, H, W) union of the beliefs of the agents that have not stopped, and of the base."""
    covered: NDArray[np.int64]
    """(B, N) counted cells in the agent's belief."""
    team_covered: NDArray[np.int64]
    """(B,) counted cells in the union."""
    sensed_count: NDArray[np.int64]
    """(B, N) counted cells the agent's own lidar has seen."""
    discovery_log: NDArray[np.int32]
    """(B, N, H*W) flat indices of known cells in the order they became known."""
    known: NDArray[np.int64]
    """(B, N) length of the discovery log."""
    merged_up_to: NDArray[np.int64]
    """(B, N, N) entries of agent j's discovery log that agent i has merged: ``merged_up_to[b, i, j]``."""
    discovered: NDArray[np.int64]
    """(B, N) cells first seen by own lidar in this step."""
    received: NDArray[np.int64]
    """(B, N) cells first received by radio in this step."""
    idle: NDArray[np.int64]
    """(B, N) steps since the last new cell of either kind."""
    history: NDArray[np.int32]
    """(B, N, window) ring of flat positions, -1 while empty."""
    reward: NDArray[np.float64]
    """(B, N) of this step."""
    linked: NDArray[np.bool_]
    """(B, N, N) in direct radio contact after this step."""
    silent_until: NDArray[np.int64]
    """(B, N) step up to which, not included, an agent's radio is silent."""
    outbox: NDArray[np.float64]
    """(B, N, 16) the message an agent sends."""
    outbox_size: NDArray[np.int64]
    """(B, N) numbers in it, -1 for no message."""
    last_received_step: NDArray[np.int64]
    """(B, N, N) step at which i last received from j, -1 for never."""
    last_received_cell: NDArray[np.int64]
    """(B, N, N, 2) j's cell at that step."""
    last_received: NDArray[np.float64]
    """(B, N, N, 16) j's message at that step."""
    last_received_size: NDArray[np.int64]
    """(B, N, N) numbers in it, -1 for no message."""
    path_length: NDArray[np.int64]
    """(B, N) cells moved."""
    collisions: NDArray[np.int64]
    """(B, N) moves into obstacles or off the map."""
    blocked: NDArray[np.int64]
    """(B, N) moves blocked by a teammate."""
    sent_bytes: NDArray[np.int64]
    """(B, N) bytes the agent's radio sent: see :mod:`indoor_explorers.env.simulation.radio`."""
    base_cell: NDArray[np.int64]
    """(B, 2) row and column of the home base."""
    base_belief: NDArray[np.uint8]
    """(B, H, W) what the base knows; (B, 0, 0) where there is no base."""
    base_log: NDArray[np.int32]
    """(B, H*W) flat indices of the cells that the base knows in the order it learned them; (B, 0) without a base."""
    base_known: NDArray[np.int64]
    """(B,) length of that log."""
    base_covered: NDArray[np.int64]
    """(B,) counted cells that the base knows."""
    base_merged: NDArray[np.int64]
    """(B, N) entries of an agent's discovery log that the base has."""
    base_sent: NDArray[np.int64]
    """(B, N) entries of the base's log that an agent has."""
    base_contact: NDArray[np.bool_]
    """(B, N) in contact with the base after this step, directly or through others."""
    base_step: NDArray[np.int64]
    """(B, N) step of the last such contact, -1 for never."""


def empty_state(
    batch: int, team: int, shape: tuple[int, int], window: int, *, base: bool = False, uncertain: bool = False
) -> State:
    """Allocate the state of ``batch`` episodes; ``base``: with a home base, ``uncertain``: poses may be wrong."""
    n, (h, w), (base_h, base_w) = team, shape, shape if base else (0, 0)

    def zeros(kind: type, *axes: int) -> NDArray:  # type: ignore[type-arg]
        return np.zeros((batch, *axes), kind)

    i8, f8, cell = np.int64, np.float64, np.zeros((batch, n, 2), np.int64)
    return State(
        truth=zeros(np.uint8, h, w),
        counts=zeros(np.bool_, h, w),
        total=zeros(i8),
        needed=zeros(i8),
        budget=zeros(i8),
        order_key=zeros(np.uint64),
        radio_key=zeros(np.uint64),
        fading=zeros(np.float64, 2),
        failure_key=zeros(np.uint64),
        step=zeros(i8),
        end=zeros(np.uint8, n),
        cell=cell,
        believed_cell=zeros(i8, n, 2) if uncertain else cell,
        legal=zeros(np.bool_, n, 5),
        belief=zeros(np.uint8, n, h, w),
        sensed=zeros(np.bool_, n, h, w),
        visited=zeros(np.bool_, n, h, w),
        union=zeros(np.uint8, h, w),
        covered=zeros(i8, n),
        team_covered=zeros(i8),
        sensed_count=zeros(i8, n),
        discovery_log=zeros(np.int32, n, h * w),
        known=zeros(i8, n),
        merged_up_to=zeros(i8, n, n),
        discovered=zeros(i8, n),
        received=zeros(i8, n),
        idle=zeros(i8, n),
        history=zeros(np.int32, n, window),
        reward=zeros(f8, n),
        linked=zeros(np.bool_, n, n),
        silent_until=zeros(i8, n),
        outbox=zeros(f8, n, MESSAGE_LIMIT),
        outbox_size=zeros(i8, n),
        last_received_step=zeros(i8, n, n),
        last_received_cell=zeros(i8, n, n, 2),
        last_received=zeros(f8, n, n, MESSAGE_LIMIT),
        last_received_size=zeros(i8, n, n),
        path_length=zeros(i8, n),
        collisions=zeros(i8, n),
        blocked=zeros(i8, n),
        sent_bytes=zeros(i8, n),
        base_cell=zeros(i8, 2),
        base_belief=zeros(np.uint8, base_h, base_w),
        base_log=zeros(np.int32, base_h * base_w),
        base_known=zeros(i8),
        base_covered=zeros(i8),
        base_merged=zeros(i8, n),
        base_sent=zeros(i8, n),
        base_contact=zeros(np.bool_, n),
        base_step=zeros(i8, n),
    )


def copied(arrays: Arrays) -> Arrays:
    """Return a named tuple with arrays of its own; an array that it has twice, its copy has twice."""
    copies = {id(array): array.copy() for array in arrays}
    return type(arrays)(*(copies[id(array)] for array in arrays))
