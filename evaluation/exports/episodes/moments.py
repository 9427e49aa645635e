"""A recorded episode simulated again step by step: its states, map frame and facts for exports."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import Scenario
from indoor_explorers.env.errors import RunError
from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.interfaces import GridFrame
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.episodes.resimulate import ended_as_recorded, resimulate


class Moment(NamedTuple):
    """The state of N UAVs after a step; its arrays are live, and change with the next one."""

    step: int
    flew: NDArray[np.bool_]
    """(N,) which UAVs flew in this step; at the start all."""
    cells: NDArray[np.int64]
    """(N, 2) row and column."""
    believed: NDArray[np.int64]
    """(N, 2) where each UAV believes to be."""
    beliefs: NDArray[np.uint8]
    """(N, H, W) each UAV's own map."""
    team: Belief
    """(H, W) the maps of all UAVs together."""
    linked: NDArray[np.bool_]
    """(N, N) which pairs are in direct radio contact."""
    heard: NDArray[np.bool_]
    """(N, N) whom each UAV hears in this step, directly or through others."""
    discovered: NDArray[np.int64]
    """(N,) cells first seen by the own lidar in this step."""
    received: NDArray[np.int64]
    """(N,) cells first received by radio in this step."""
    coverage: float
    """Share of the denominator that the team knows."""


def moments(record: Record, scenario: Scenario) -> Iterator[Moment]:
    """Yield the start of a recorded episode, and the moment after each of its steps.

    Raises:
        RunError: after the last, if the episode did not end as recorded.

    """
    flew = np.ones(record.team, np.bool_)
    for step, world in enumerate(resimulate(record, scenario)):
        state = world.state
        yield Moment(
            *(step, flew, state.cell[0], state.believed_cell[0], state.belief[0], state.union[0], state.linked[0]),
            heard=(state.last_received_step[0] == step) & flew[:, None],
            discovered=state.discovered[0],
            received=state.received[0],
            coverage=float(world.team_coverage[0]),
        )
        flew = world.flying[0]
    if not ended_as_recorded(record, world):
        raise RunError(
            f"{record.policy} on {record.task.scenario}, seed {record.task.seed}: the episode is not as stored when it "
            "is simulated again; export it with the version of the software that has flown it"
        )


def frame_of(record: Record) -> GridFrame:
    """Return where the cells of an episode's map lie in metres; a cell is one metre where the map does not say."""
    return GridFrame(shape=record.floorplan.shape, resolution=record.floorplan.resolution or 1.0)


def facts_of(record: Record, step_seconds: float) -> dict[str, Any]:
    """Return what an episode is, as JSON data: task, outcome, map and times."""
    frame = frame_of(record)
    return {
        "policy": record.policy,
        "scenario": record.task.scenario,
        "map": record.floorplan.name,
        "map_index": record.task.map_index,
        "seed": record.task.seed,
        "team": record.team,
        "rows": frame.shape[0],
        "columns": frame.shape[1],
        "resolution": frame.resolution,
        "reachable": record.reachable,
        "budget": record.budget,
        "steps": record.steps,
        "step_seconds": step_seconds,
        "outcome": str(record.outcome),
        "reason": record.reason,
    }
