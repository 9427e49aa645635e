"""The starts of a batch's episodes, drawn and checked in several threads before any state changes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.randomness import checked_seed
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.sources import ThesisMaps
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.reset import (
    FloodScratch,
    RoomTask,
    Starts,
    draw_rooms,
    empty_starts,
    flood_scratch,
    mark_reachable,
)
from indoor_explorers.env.simulation.spawns import checked_spawns, draw_floorplan, draw_spawns
from indoor_explorers.env.simulation.state import rules_of

#: Episodes that make another thread worthwhile; waking a thread takes about as long as stepping this many.
LEAST_SHARE = 16
#: (H, W) of the maps of a batch, None before its first episode.
Shape = tuple[int, ...] | None


class Threads:
    """Call compiled work in up to ``count`` threads, this one included."""

    def __init__(self, count: int) -> None:
        self.count = count
        self._pool = ThreadPoolExecutor(count - 1, "world") if count > 1 else None

    def share(self, work: Callable[[int, int, int], object], size: int) -> None:
        """Call ``work(thread, first, last)`` for a share of ``size`` items in each thread, and wait for all."""
        threads = min(self.count, size // LEAST_SHARE + 1)
        if self._pool is None or threads == 1:
            work(0, 0, size)
            return
        bounds = [size * thread // threads for thread in range(threads + 1)]
        others = [self._pool.submit(work, t, bounds[t], bounds[t + 1]) for t in range(1, threads)]
        try:
            work(0, 0, bounds[1])
        finally:
            wait(others)
        for other in others:
            other.result()


class Prepared(NamedTuple):
    """K episodes that can be started."""

    episodes: NDArray[np.int64]
    """(K,) their places in the batch."""
    seeds: NDArray[np.int64]
    """(K,)."""
    starts: Starts
    floorplans: Sequence[Floorplan | None]
    """Their maps; None for a room that was drawn in compiled code."""


class Preparation:
    """Draw the maps and spawns of a scenario's episodes."""

    def __init__(self, scenario: Scenario, batch: int, threads: Threads) -> None:
        self._scenario = scenario
        self._batch = batch
        self._threads = threads
        self._room = _room_task(scenario)
        self._scratch: list[FloodScratch] = []

    def drawn(self, episodes: Sequence[int], seeds: Sequence[int], index: int, shape: Shape) -> Prepared:
        """Draw the maps and spawns of some episodes; maps must have the batch's ``shape``."""
        places, keys = self._checked(episodes, seeds, index)
        if self._room is not None:
            return self._drawn_rooms(self._room, places, keys, shape)
        plans = [draw_floorplan(self._scenario, seed, index) for seed in keys.tolist()]
        cells = [draw_spawns(self._scenario, plan, seed) for plan, seed in zip(plans, keys.tolist(), strict=True)]
        return self._gathered(places, keys, plans, cells, shape)

    def given(
        self,
        episode: int,
        seed: int,
        index: int,
        shape: Shape,
        floorplan: Floorplan | None,
        spawns: Sequence[Cell] | None,
    ) -> Prepared:
        """Prepare one episode with a given map or given spawns; the other one is drawn."""
        place, key = self._checked([episode], [seed], index)
        plan = draw_floorplan(self._scenario, seed, index) if floorplan is None else floorplan
        if spawns is None:
            cells = draw_spawns(self._scenario, plan, seed)
        else:
            cells = checked_spawns(spawns, plan, self._scenario.team)
        return self._gathered(place, key, [plan], [cells], shape)

    def _checked(
        self, episodes: Sequence[int], seeds: Sequence[int], index: int
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return episodes (K,) and their seeds (K,), refusing what is out of range."""
        if len(episodes) != len(seeds):
            raise InputError(f"expected one seed for each of {len(episodes)} episodes, got {len(seeds)}")
        if not 0 <= index < self._scenario.map.count:
            raise InputError(f"expected index to be one of the scenario's {self._scenario.map.count} maps, got {index}")
        places = np.array(episodes, np.int64)
        if len(places) and not 0 <= places.min() <= places.max() < self._batch:
            raise InputError(f"expected episodes from 0 to {self._batch - 1}, got {places.tolist()}")
        if len(places) > 1 and len(np.unique(places)) < len(places):
            raise InputError(f"expected each episode once, got {places.tolist()}")
        return places, np.array([checked_seed(seed) for seed in seeds], np.int64)

    def _drawn_rooms(
        self, task: RoomTask, episodes: NDArray[np.int64], seeds: NDArray[np.int64], shape: Shape
    ) -> Prepared:
        """Draw random rooms and spawns in compiled code."""
        maps = self._scenario.map
        assert isinstance(maps, ThesisMaps)
        _check_shape((maps.height, maps.width), shape, maps.source)
        starts = empty_starts(len(episodes), self._scenario.team, (maps.height, maps.width))
        scratch = self._scratch_for((maps.height, maps.width))

        def draw(thread: int, first: int, last: int) -> None:
            drawn = draw_rooms(task, scratch[thread], starts, seeds, first, last)
            if drawn < last:
                draw_floorplan(self._scenario, int(seeds[drawn]))  # raises the error
                raise AssertionError("a floor plan was drawn where compiled code found none")

        self._threads.share(draw, len(episodes))
        return Prepared(episodes, seeds, starts, [None] * len(episodes))

    def _gathered(
        self,
        episodes: NDArray[np.int64],
        seeds: NDArray[np.int64],
        plans: Sequence[Floorplan],
        cells: Sequence[Sequence[Cell]],
        shape: Shape,
    ) -> Prepared:
        """Put maps and spawns into arrays."""
        if not plans:
            return Prepared(episodes, seeds, empty_starts(0, self._scenario.team, (0, 0)), plans)
        for plan in plans:
            _check_shape(plan.shape, shape or plans[0].shape, plan.name)
            if plan.level_count != (count := self._scenario.map.level_count):
                raise InputError(f"{plan.name}: expected a map of {count} levels, got {plan.level_count}")
        starts = empty_starts(len(plans), self._scenario.team, plans[0].shape)
        for k, plan in enumerate(plans):
            starts.truth[k], starts.cell[k] = plan.truth, cells[k]
        mark_reachable(self._scratch_for(plans[0].shape)[0], starts, plans[0].levels.rise)
        if not isinstance(self._scenario.base.at, str):
            for plan, reachable in zip(plans, starts.reachable, strict=True):
                _check_base(self._scenario.base.at, plan, reachable)
        return Prepared(episodes, seeds, starts, plans)

    def _scratch_for(self, shape: tuple[int, int]) -> list[FloodScratch]:
        """Return the working arrays of each thread."""
        if not self._scratch or self._scratch[0].part.shape != shape:
            self._scratch = [flood_scratch(shape) for _ in range(self._threads.count)]
        return self._scratch


def _room_task(scenario: Scenario) -> RoomTask | None:
    """Return the task of rooms that compiled code can draw; None for other maps, and for listed spawns or bases."""
    if not (
        isinstance(scenario.map, ThesisMaps) and isinstance(scenario.spawn, str) and isinstance(scenario.base.at, str)
    ):
        return None
    rules = rules_of(scenario)
    return RoomTask(scenario.map.room, scenario.spawn == "clustered", rules.count_all_cells, rules.goal)


def _check_base(base: Cell, plan: Floorplan, reachable: NDArray[np.bool_]) -> None:
    """Refuse a base in a cell that no UAV can reach."""
    (row, col), (height, width) = base, plan.shape
    if not (0 <= row < height and 0 <= col < width and reachable[row, col]):
        raise InputError(
            f"{plan.name}: base.at ({row}, {col}) is no cell of this {height} x {width} map that can be reached from "
            "the spawns; list another one, or use 'start'"
        )


def _check_shape(found: tuple[int, int], shape: Shape, name: str) -> None:
    """Refuse a map of another shape than the batch's."""
    if shape is not None and found != shape:
        raise InputError(
            f"expected a map of shape {shape} like the others of the batch, got {found} ({name}); "
            "use a world for each shape"
        )
