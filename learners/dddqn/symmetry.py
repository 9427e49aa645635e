"""The eight flips and quarter turns of the world, as permutations of observations and moves."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid import MOVES
from indoor_explorers.learners.dddqn.observation import COARSE, FINE

#: How many there are; number 0 leaves everything as it is.
SYMMETRIES = 8


class Symmetries(NamedTuple):
    """Index tables: under symmetry g an array ``x`` becomes ``x[table[g]]``."""

    scene: NDArray[np.int64]
    """(8, 696) for the scene."""
    moves: NDArray[np.int64]
    """(8, 4) for the rows of the move features."""
    action: NDArray[np.int64]
    """(8, 4) the move that each move turns into."""


def turned(array: NDArray[Any], symmetry: int) -> NDArray[Any]:
    """Return a (H, W) array under one of the eight symmetries: mirrored from 4 on, then turned."""
    return np.rot90(np.fliplr(array) if symmetry >= 4 else array, symmetry % 4)


def _turned_moves(symmetry: int) -> list[int]:
    """Return the move that each of the four moves turns into."""
    result = []
    for row, col in MOVES[:4]:
        marked = np.zeros((3, 3))
        marked[1 + row, 1 + col] = 1
        seen = np.argwhere(turned(marked, symmetry))[0] - 1
        result.append(int(np.flatnonzero((MOVES[:4] == seen).all(axis=1))[0]))
    return result


@lru_cache(maxsize=1)
def symmetries() -> Symmetries:
    """Return the tables."""
    action = np.array([_turned_moves(g) for g in range(SYMMETRIES)])
    moves = np.argsort(action, axis=1)
    scene = []
    for g in range(SYMMETRIES):
        parts, start = [], 0
        for side in (FINE, FINE, COARSE, COARSE):
            index = np.arange(start, start + side * side).reshape(side, side)
            parts.append(turned(index, g).ravel())
            start += side * side
        scene.append(np.concatenate([*parts, start + moves[g]]))
    return Symmetries(scene=np.array(scene), moves=moves, action=action)
