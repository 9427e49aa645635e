"""The state of a batch of episodes as plain arrays, and the rules as plain numbers.

Axes: B episodes, N agents, H rows, W columns, ``cells`` = H * W; of maps with several levels, H and W are those of
their plane. Compiled kernels read and write these; everything else
goes through :class:`indoor_explorers.env.simulation.world.World`.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import allocated
from indoor_explorers.env.grid.levels import Levels
from indoor_explorers.env.policies.view import MESSAGE_LIMIT, Mate
from indoor_explorers.env.scenarios.codes import RadioModel, StuckRule
from indoor_explorers.env.scenarios.scenario import LEAST_BUDGET, Scenario


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
    """It made no discovery or visited the same cells for too long by the rule ``stuck``."""
    BUDGET = 5
    """All steps are flown."""
    STOPPED = 6
    """It failed, see :mod:`indoor_explorers.env.simulation.contacts`."""


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
    """Whether the step itself scans: without a plug-in lidar and without errors."""
    radio_model: int
    radio_range: float
    radio_exponent: float
    radio_wall_loss: float
    radio_loss: float
    goal_of_team: bool
    """Whether the goal is the team's coverage; at most one of the three goals is set, none for a goal of each agent."""
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
    """Row of the base; -1 for the start cell of agent 0."""
    base_col: int
    base_radius: float
    goal_of_base: bool
    """Whether the goal is the base's coverage."""
    levels: int
    """L, levels of the maps, which lie in a plane (:mod:`indoor_explorers.env.grid.levels`)."""


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
        goal_of_team=scenario.goal_of == "team" and not scenario.base.must_return,
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
        levels=scenario.map.level_count,
    )


def _stop_steps(scenario: Scenario) -> NDArray[np.int64]:
    steps = np.zeros(scenario.team, np.int64)
    for agent, step in scenario.failures.stops:
        steps[agent] = step
    return steps


class State(NamedTuple):
    """The state of a batch of episodes."""

    truth: Annotated[NDArray[np.uint8], "B H W"]
    """1 free, 2 occupied."""
    counts: Annotated[NDArray[np.bool_], "B H W"]
    """Cells that coverage counts."""
    total: Annotated[NDArray[np.int64], "B"]
    """Number of those cells: the denominator."""
    needed: Annotated[NDArray[np.int64], "B"]
    """Number of those cells that must be known to reach the goal."""
    budget: Annotated[NDArray[np.int64], "B"]
    """Steps."""
    order_key: Annotated[NDArray[np.uint64], "B"]
    """Key of the stream that draws the order of moves."""
    radio_key: Annotated[NDArray[np.uint64], "B"]
    """Key of the stream that draws which contacts fail."""
    fading: Annotated[NDArray[np.float64], "B 2"]
    """K and X of the radio model ``path-loss-ir2``, in dB."""
    failure_key: Annotated[NDArray[np.uint64], "B"]
    """Key of the stream that draws which UAVs and radios fail."""
    step: Annotated[NDArray[np.int64], "B"]
    """Steps flown."""
    end: Annotated[NDArray[np.uint8], "B N"]
    """:class:`End`."""
    cell: Annotated[NDArray[np.int64], "B N 2"]
    """Row and column."""
    believed_cell: Annotated[NDArray[np.int64], "B N 2"]
    """Each agent's estimate of its cell: the same array as ``cell`` without pose errors."""
    legal: Annotated[NDArray[np.bool_], "B N moves"]
    """Actions that end neither in a wall nor off the map."""
    belief: Annotated[NDArray[np.uint8], "B N H W"]
    """0 unknown, 1 free, 2 occupied."""
    sensed: Annotated[NDArray[np.bool_], "B N H W"]
    """Cells the agent's own lidar has seen."""
    visited: Annotated[NDArray[np.bool_], "B N H W"]
    """Cells the agent has been in."""
    union: Annotated[NDArray[np.uint8], "B H W"]
    """Union of the beliefs of the agents that have not stopped, and of the base."""
    covered: Annotated[NDArray[np.int64], "B N"]
    """Counted cells in the agent's belief."""
    team_covered: Annotated[NDArray[np.int64], "B"]
    """Counted cells in the union."""
    sensed_count: Annotated[NDArray[np.int64], "B N"]
    """Counted cells the agent's own lidar has seen."""
    discovery_log: Annotated[NDArray[np.int32], "B N cells"]
    """Flat indices of known cells in the order they became known."""
    known: Annotated[NDArray[np.int64], "B N"]
    """Length of the discovery log."""
    merged_up_to: Annotated[NDArray[np.int64], "B N N"]
    """Entries of agent j's discovery log that agent i has merged: ``merged_up_to[b, i, j]``."""
    discovered: Annotated[NDArray[np.int64], "B N"]
    """Cells first seen by own lidar in this step."""
    received: Annotated[NDArray[np.int64], "B N"]
    """Cells first received by radio in this step."""
    idle: Annotated[NDArray[np.int64], "B N"]
    """Steps since the last new cell of either kind."""
    history: Annotated[NDArray[np.int32], "B N window"]
    """Ring of flat positions, -1 while empty."""
    reward: Annotated[NDArray[np.float64], "B N"]
    """Reward of this step."""
    linked: Annotated[NDArray[np.bool_], "B N N"]
    """In direct radio contact after this step."""
    silent_until: Annotated[NDArray[np.int64], "B N"]
    """Step up to which, not included, an agent's radio is silent."""
    outbox: Annotated[NDArray[np.float64], "B N message"]
    """The message an agent sends."""
    outbox_size: Annotated[NDArray[np.int64], "B N"]
    """Numbers in it, -1 for no message."""
    last_received_step: Annotated[NDArray[np.int64], "B N N"]
    """Step at which i last received from j, -1 for never."""
    last_received_cell: Annotated[NDArray[np.int64], "B N N 2"]
    """Cell of j at that step."""
    last_received: Annotated[NDArray[np.float64], "B N N message"]
    """Message of j at that step."""
    last_received_size: Annotated[NDArray[np.int64], "B N N"]
    """Numbers in it, -1 for no message."""
    path_length: Annotated[NDArray[np.int64], "B N"]
    """Cells moved."""
    collisions: Annotated[NDArray[np.int64], "B N"]
    """Moves into obstacles or off the map."""
    blocked: Annotated[NDArray[np.int64], "B N"]
    """Moves blocked by a teammate."""
    sent_bytes: Annotated[NDArray[np.int64], "B N"]
    """Bytes the agent's radio sent: see :mod:`indoor_explorers.env.simulation.radio`."""
    base_cell: Annotated[NDArray[np.int64], "B 2"]
    """Row and column of the home base."""
    base_belief: Annotated[NDArray[np.uint8], "B base_H base_W"]
    """The base's map; (B, 0, 0) without a base."""
    base_log: Annotated[NDArray[np.int32], "B base_cells"]
    """Flat indices of the cells that the base knows in the order it learned them; (B, 0) without a base."""
    base_known: Annotated[NDArray[np.int64], "B"]
    """Length of that log."""
    base_covered: Annotated[NDArray[np.int64], "B"]
    """Counted cells that the base knows."""
    base_merged: Annotated[NDArray[np.int64], "B N"]
    """Entries of an agent's discovery log that the base has."""
    base_sent: Annotated[NDArray[np.int64], "B N"]
    """Entries of the base's log that an agent has."""
    base_contact: Annotated[NDArray[np.bool_], "B N"]
    """In contact with the base after this step, directly or through others."""
    base_step: Annotated[NDArray[np.int64], "B N"]
    """Step of the last such contact, -1 for never."""


def empty_state(scenario: Scenario, batch: int, shape: tuple[int, int]) -> State:
    """Allocate the state of ``batch`` episodes of a scenario on (H, W) maps."""
    window = scenario.stuck.window if scenario.stuck.rule == "oscillation" else 1
    base_shape = shape if scenario.base.exists else (0, 0)
    sizes = dict(zip(("H", "W", "base_H", "base_W"), (*shape, *base_shape), strict=True))
    sizes |= {"cells": sizes["H"] * sizes["W"], "base_cells": sizes["base_H"] * sizes["base_W"]}
    sizes |= {"moves": Levels.of(shape, scenario.map.level_count).moves, "message": MESSAGE_LIMIT}
    state = allocated(State, B=batch, N=scenario.team, window=window, **sizes)
    return state if scenario.uncertain else state._replace(believed_cell=state.cell)


def received_mates(state: State, b: int, agent: int) -> tuple[Mate, ...]:
    """Return what an agent of episode ``b`` last received of each teammate."""
    now, mates = int(state.step[b]), []
    for mate, when in enumerate(state.last_received_step[b, agent].tolist()):
        if when >= 0:
            row, col = state.last_received_cell[b, agent, mate].tolist()
            size = int(state.last_received_size[b, agent, mate])
            message = tuple(state.last_received[b, agent, mate, :size].tolist()) if size >= 0 else None
            mates.append(Mate(mate, (row, col), now - when, message))
    return tuple(mates)
