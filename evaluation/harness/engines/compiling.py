"""Workers share the compiling of the world's code on a machine that has none of it yet.

Each takes a part that no other process compiles, instead of waiting for the functions that all need first.
"""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from indoor_explorers.env import Scenario, World
from indoor_explorers.env.files import locked
from indoor_explorers.env.grid.cells import FREE, Action
from indoor_explorers.env.grid.compile_cache import cache_folder, not_compiled
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.evaluation.harness.episodes.lower_bounds import lower_bounds

#: Rows and columns of the open map on which the parts run.
SIDE = 4


def compile_world() -> None:
    """Compile what starts, steps and bounds episodes, but for parts that other processes compile at the moment.

    Where steps are compiled already, nothing is done.
    """
    folder = cache_folder()
    if folder is None or not any(label.startswith("advance-") for label in not_compiled()):
        return
    for part in (_start, _bound, _step):
        with suppress(OSError), locked(folder / f"{part.__name__}.lock") as alone:
            if alone:
                part()


def _start() -> None:
    open_map = np.full((SIDE, SIDE), FREE, np.uint8)
    World(Scenario()).begin(0, 0, floorplan=Floorplan(open_map, "open"))


def _bound() -> None:
    lower_bounds(_open_world(), 0, 1.0)


def _step() -> None:
    world = _open_world()
    world.step(np.full((1, world.scenario.team), int(Action.STAY)))


def _open_world() -> World:
    """Return a world on an open map, with the UAVs in one corner; no code that starts episodes has run."""
    world = World(Scenario())
    world.allocate((SIDE, SIDE))
    world.state.truth[:], world.state.counts[:] = FREE, True
    return world
