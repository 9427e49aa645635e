"""A recorded episode simulated again step by step: its states, map frame and facts for exports."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import Scenario
from indoor_explorers.env.errors import RunError
from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.levels import Levels
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


@dataclass(frozen=True, kw_only=True)
class MapFrame(GridFrame):
    """The position of the cells of some levels, each of the frame's shape, in the ROS frame ``map``."""

    levels: Levels

    def places(self, cells: NDArray[np.integer]) -> NDArray[np.float64]:
        """Return (x, y, z) (..., 3) in metres of the centres of cells (..., 2) of the plane.

        z is 0 where there is one level.
        """
        level, row, col = np.moveaxis(self.levels.voxels(cells) + 0.5, -1, 0)
        x, y = self.origin[0] + col * self.resolution, self.origin[1] + (self.shape[0] - row) * self.resolution
        return np.stack((x, y, level * self.resolution * (self.levels.number > 1)), axis=-1)

    def place(self, cell: Sequence[int]) -> tuple[float, float, float]:
        """Return the same of one cell."""
        x, y, z = self.places(np.asarray(cell)).tolist()
        return x, y, z


def frame_of(record: Record) -> MapFrame:
    """Return where the cells of an episode's map lie in metres; a cell is one metre where the map does not say."""
    plan, levels = record.floorplan, record.floorplan.levels
    return MapFrame(shape=(levels.height, levels.width), resolution=plan.resolution or 1.0, levels=levels)


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
        **({"levels": frame.levels.number} if frame.levels.number > 1 else {}),
        "resolution": frame.resolution,
        "reachable": record.reachable,
        "budget": record.budget,
        "steps": record.steps,
        "step_seconds": step_seconds,
        "outcome": str(record.outcome),
        "reason": record.reason,
    }
