"""Benchmarks of the speed of the world against map size, lidar range, team size and batch size.

UAVs explore steadily (:mod:`indoor_explorers.evaluation.studies.bench.exploring`). Map size, range and team are
measured on one core without the starts of episodes, whose cost grows with the map; the batch on all cores with them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from indoor_explorers.env.scenarios.parts import Radio
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.evaluation.studies.bench.exploring import exploring_moves
from indoor_explorers.evaluation.studies.bench.figure import cores
from indoor_explorers.evaluation.studies.bench.worlds import WORLDS, square, world_speed

#: Steps of a repetition.
STEPS = 100
#: Episodes in a batch of fixed size.
BATCH = 16


class GrowthSeries(NamedTuple):
    """One quantity that varies."""

    name: str
    """Beginning of the names of its figures."""
    quantity: str
    rest: str
    sizes: tuple[int, ...]
    label: Callable[[int], str]
    """The size in the name of a figure."""
    speed: Callable[[int], float]
    """Agent-steps a second at a size."""


def _steady(task: Scenario) -> float:
    """Return agent-steps a second on one core, without starts of episodes."""
    moves = exploring_moves(task, BATCH, STEPS)
    return world_speed(task, BATCH, STEPS, moves=moves, resets=False)


def _at_batch(batch: int) -> float:
    task, _ = WORLDS["world-16x16-lidar3-team1"]
    steps = 4 * STEPS
    return world_speed(task, batch, steps, threads=cores(), moves=exploring_moves(task, batch, steps))


def _team(size: int) -> float:
    return _steady(square(128, 5.0, size, Radio(model="disc", range=15.0)))


SERIES = (
    GrowthSeries(
        *("growth-area", "side of the map in cells", "one UAV, lidar 5, one core"),
        (16, 32, 64, 128, 256, 512, 1024),
        lambda side: f"{side}x{side}",
        lambda side: _steady(square(side, 5.0, 1)),
    ),
    GrowthSeries(
        *("growth-lidar", "lidar range in cells", "one UAV, map 256x256, one core"),
        (1, 3, 5, 10, 20, 35, 50),
        str,
        lambda cells: _steady(square(256, float(cells), 1)),
    ),
    GrowthSeries(
        *("growth-team", "UAVs in the team", "map 128x128, lidar 5, radio disc 15, one core"),
        (1, 2, 4, 8, 16, 32, 64),
        str,
        _team,
    ),
    GrowthSeries(
        *("growth-batch", "episodes in the batch", "one UAV, map 16x16, lidar 3, all cores"),
        (1, 4, 16, 64, 256, 1024, 4096),
        str,
        _at_batch,
    ),
)


def growth() -> dict[str, Callable[[], float]]:
    """Return a function that measures each figure, by name."""
    return {
        f"{series.name}-{series.label(size)}": partial(series.speed, size) for series in SERIES for size in series.sizes
    }
