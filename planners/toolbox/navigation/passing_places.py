"""Passing places: cells with at least three free neighbours, where another UAV can get past."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from indoor_explorers.env.grid.arrays import Belief, Cell, Mask
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.planners.toolbox.navigation.paths import Paths, without

#: Number of nearest passing places that one is drawn from; the very nearest may be the mouth of the corridor itself.
CHOICE = 12


def passing_places(belief: Belief) -> Mask:
    """Return which cells of a (H, W) belief are free and have three free 4-neighbours or more, (H, W) bool."""
    free = np.pad(belief == FREE, 1).astype(np.int8)
    around = free[:-2, 1:-1] + free[2:, 1:-1] + free[1:-1, :-2] + free[1:-1, 2:]
    return np.asarray((around >= 3) & (free[1:-1, 1:-1] > 0))


def path_to_passing_place(
    paths: Paths, belief: Belief, cell: Cell, reach: int, rng: np.random.Generator, barred: Iterable[Cell] = ()
) -> list[Cell] | None:
    """Return a path to one of the nearest passing places at most ``reach`` steps from ``cell``; None if there is none.

    ``belief`` is (H, W). The path is a list of (row, column) and avoids the cells of ``barred``.
    """
    barred = list(barred)
    steps = paths.field(without(belief, barred), cell)
    found = np.flatnonzero(passing_places(belief) & (steps > 0) & (steps <= reach))
    if len(found) == 0:
        return None
    nearest = found[np.argsort(steps.ravel()[found], kind="stable")[:CHOICE]]
    return paths.to(belief, cell, divmod(int(rng.choice(nearest)), paths.width), barred)
