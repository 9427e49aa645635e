"""Benchmarks of the world: agent-steps a second, scans, starts, and bytes of an episode."""

from __future__ import annotations

import time
from collections.abc import Iterator
from itertools import count

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import Scenario, World
from indoor_explorers.env.grid.cells import FREE, Action
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.maps.sources import StoreysMaps, ThesisMaps
from indoor_explorers.env.observations.incremental import LivePlanes
from indoor_explorers.env.scenarios.parts import Lidar, Radio
from indoor_explorers.env.sensing.lidar import LidarModel, Scan, lidar_model, new_scan, visible_cells
from indoor_explorers.evaluation.studies.bench.figure import median_of, seconds_of

#: Steps of a repetition, and the budget of an episode.
STEPS = 400


def square(side: int, lidar_range: float, team: int, radio: Radio | None = None) -> Scenario:
    """Return a square room with about the thesis's density of obstacles; hitting a wall only costs a step."""
    return Scenario(
        name=f"{side}x{side}",
        map=ThesisMaps(height=side, width=side, obstacles=5 * side * side // 256),
        team=team,
        lidar=Lidar(range=lidar_range),
        radio=radio or (Radio(model="square", range=lidar_range) if team > 1 else Radio()),
        on_collision="block",
        goal=1.0,
        goal_of="team",
        budget=STEPS,
    )


def tall(side: int, levels: int, lidar_range: float, team: int, radio: Radio | None = None) -> Scenario:
    """Return a storey of some levels: rooms, corridors and furniture; hitting a wall only costs a step."""
    task = square(side, lidar_range, team, radio)
    maps = StoreysMaps(height=side, width=side, storeys=1, storey_height=levels)
    return task.model_copy(update={"name": f"{side}x{side}x{levels}", "map": maps})


#: Worlds whose speed is measured: (scenario, batch size, which is about the fastest on two cores).
WORLDS = {
    "world-16x16-lidar3-team1": (square(16, 3.0, 1), 8192),
    "world-16x16-lidar3-team4": (square(16, 3.0, 4), 2048),
    "world-64x64-lidar10-team4": (square(64, 10.0, 4), 256),
    "world-250x250-lidar35-team2": (square(250, 35.0, 2), 64),
    "world-64x64x6-lidar10-team4": (tall(64, 6, 10.0, 4), 64),
}
#: The smaller of them with errors of lidar and poses, on one core.
ERRORS = {"noise.misses": 0.05, "noise.false_returns": 0.001, "noise.range_std": 0.2, "drift.rate": 0.001}
UNCERTAIN = {
    f"{name}-errors-core": (task.with_settings(ERRORS), batch // 8) for name, (task, batch) in list(WORLDS.items())[:3]
}


def random_moves(batch: int, team: int, steps: int = 64, levels: int = 1) -> NDArray[np.int64]:
    """Return (steps, B, N) moves in random directions, blind to walls; also up and down where there are levels."""
    moves = np.random.default_rng(0).integers(0, 4 if levels == 1 else 6, (steps, batch, team))
    return moves + (moves >= Action.STAY)


def world_speed(
    task: Scenario,
    batch: int,
    steps: int = STEPS,
    *,
    threads: int = 1,
    moves: NDArray[np.int64] | None = None,
    resets: bool = True,
) -> float:
    """Return agent-steps a second, including rewards, ends, observations and, with ``resets``, new episodes.

    Observations are all planes of ``channels``, kept up to date in place
    (:mod:`indoor_explorers.env.observations.incremental`). ``moves`` (K, B, N) are repeated, random ones by default.
    Every repetition flies the same episodes, so moves recorded by
    :func:`indoor_explorers.evaluation.studies.bench.exploring.exploring_moves` fit them.
    """
    world = World(task, batch, threads=threads)
    actions = random_moves(batch, task.team, levels=task.map.level_count) if moves is None else moves
    world.reset(range(batch))
    live = LivePlanes(world)

    def fly() -> float:
        """Return the seconds of an agent-step; new episodes are only timed with ``resets``."""
        seeds, seconds, flown = first_episodes(world), 0.0, 0
        live.update()
        for step in range(steps):
            flown += int(np.count_nonzero(world.flying))
            before = time.perf_counter()
            live.step(actions[step % len(actions)])
            if resets and next_episodes(world, seeds):
                live.update()
            seconds += time.perf_counter() - before
        return seconds / flown

    return 1.0 / median_of(fly)


def first_episodes(world: World) -> Iterator[int]:
    """Start the episodes of the first seeds, and return an iterator over the next seeds."""
    world.reset(range(world.batch))
    return count(world.batch)


def next_episodes(world: World, seeds: Iterator[int]) -> bool:
    """Start a new episode wherever one is over; return whether any was."""
    over = np.flatnonzero(~world.flying.any(axis=1)).tolist()
    if over:
        world.restart(over, [next(seeds) for _ in over])
    return bool(over)


def memory(task: Scenario) -> float:
    """Return the bytes of one episode of a batch, over all arrays of the state."""
    world = World(task, 2)
    world.reset([0, 1])
    return sum(array.nbytes for array in world.state) / world.batch


def reset_time(task: Scenario, episodes: int = 50) -> float:
    """Return the median microseconds of starting an episode, including its map and first scans."""
    world, seconds = World(task), []
    for seed in range(episodes + 1):
        start = time.perf_counter()
        world.restart([0], [seed])
        seconds.append(time.perf_counter() - start)
    return float(np.median(seconds[1:])) * 1e6


@kernel()
def _scan_all(truth: np.ndarray, places: np.ndarray, lidar: LidarModel, work: Scan) -> int:
    """Scan from each of the places (K, 2); return the cells seen."""
    seen = 0
    for k in range(places.shape[0]):
        seen += visible_cells(truth, places[k, 0], places[k, 1], lidar, work)
    return seen


def scan_time(lidar_range: float, scans: int = 1000) -> float:
    """Return the microseconds of a scan from random free cells of a room of 250x250 with obstacles."""
    world = World(square(250, lidar_range, 1))
    world.reset([0])
    truth, lidar = world.state.truth[0], lidar_model(lidar_range)
    places = np.random.default_rng(0).permutation(np.argwhere(truth == FREE))[:scans]
    work = new_scan(lidar)
    return median_of(lambda: seconds_of(lambda: _scan_all(truth, places, lidar, work))) / len(places) * 1e6
