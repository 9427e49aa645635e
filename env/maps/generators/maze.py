"""Mazes: a depth-first random spanning tree of a grid of junctions, with some of its dead ends opened.

The tree is that of the recursive backtracker: long winding corridors, one path between any two places. Opening
dead ends ("braiding") makes loops. See Buck, Mazes for Programmers (2015), chapters 5 and 9.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.cells import MOVES
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.grid.randomness import draw
from indoor_explorers.env.maps.base import GeneratedMaps, check_room


class MazeMaps(GeneratedMaps):
    """Random mazes; the rest of the map around the grid of corridors stays solid."""

    source: Literal["maze"] = "maze"
    height: int = Field(65, ge=5, le=2048)
    """Cells; a whole number of ``corridor + wall`` and one more ``wall`` is filled to the edge."""
    width: int = Field(65, ge=5, le=2048)
    """Cells; as the height."""
    corridor: int = Field(3, ge=1, le=64)
    """Cells from wall to wall of a corridor."""
    wall: int = Field(1, ge=1, le=64)
    """Cells through a wall."""
    braid: float = Field(0.1, ge=0.0, le=1.0)
    """Share of dead ends opened into a neighbouring corridor; 0 is a perfect maze, 1 has none left."""

    @model_validator(mode="after")
    def _consistent(self) -> MazeMaps:
        least = self.corridor + 2 * self.wall
        check_room("height", self.height, least, "a corridor between two walls")
        check_room("width", self.width, least, "a corridor between two walls")
        return self

    def draw(self, rng: np.random.Generator) -> Mask:
        """Return the (height, width) mask of the corridors."""
        pitch = self.corridor + self.wall
        shape = ((self.height - self.wall) // pitch, (self.width - self.wall) // pitch)
        open_ = spanning_tree(shape[0], shape[1], rng.integers(2**64, dtype=np.uint64))
        braided(open_, self.braid, rng.integers(2**64, dtype=np.uint64))
        rows, cols = (np.tile([self.wall, self.corridor], side + 1)[:-1] for side in shape)
        maze = np.repeat(np.repeat(open_, rows, axis=0), cols, axis=1)
        spare = self.height - maze.shape[0], self.width - maze.shape[1]
        return np.pad(maze, [(side // 2, side - side // 2) for side in spare])


@kernel()
def spanning_tree(rows: int, cols: int, key: np.uint64) -> NDArray[np.bool_]:
    """Return the (2*rows + 1, 2*cols + 1) bool lattice of a random maze: junctions, and the openings between them.

    Junction (r, c) is at (2r + 1, 2c + 1). ``key`` seeds the depth-first search.
    """
    lattice = np.zeros((2 * rows + 1, 2 * cols + 1), np.bool_)
    stack = np.empty(rows * cols, np.int64)
    choices = np.empty(4, np.int64)
    counter, top = np.uint64(0), 1
    start = np.int64(draw(key, counter) % np.uint64(rows * cols))
    stack[0] = start
    lattice[2 * (start // cols) + 1, 2 * (start % cols) + 1] = True
    while top > 0:
        r, c = 2 * (stack[top - 1] // cols) + 1, 2 * (stack[top - 1] % cols) + 1
        found = 0
        for k in range(4):
            rr, cc = r + 2 * MOVES[k, 0], c + 2 * MOVES[k, 1]
            if 0 < rr < 2 * rows and 0 < cc < 2 * cols and not lattice[rr, cc]:
                choices[found] = k
                found += 1
        if found == 0:
            top -= 1
            continue
        counter += np.uint64(1)
        k = choices[np.int64(draw(key, counter) % np.uint64(found))]
        lattice[r + MOVES[k, 0], c + MOVES[k, 1]] = True
        lattice[r + 2 * MOVES[k, 0], c + 2 * MOVES[k, 1]] = True
        stack[top] = (r // 2 + MOVES[k, 0]) * cols + c // 2 + MOVES[k, 1]
        top += 1
    return lattice


@kernel()
def braided(lattice: NDArray[np.bool_], share: float, key: np.uint64) -> None:
    """Open a ``share`` of the dead ends of a lattice (H, W) bool in place, each into a random neighbour."""
    rows, cols = lattice.shape[0] // 2, lattice.shape[1] // 2
    choices = np.empty(4, np.int64)
    for junction in range(rows * cols):
        r, c = 2 * (junction // cols) + 1, 2 * (junction % cols) + 1
        exits = found = 0
        for k in range(4):
            if lattice[r + MOVES[k, 0], c + MOVES[k, 1]]:
                exits += 1
            elif 0 < r + 2 * MOVES[k, 0] < 2 * rows and 0 < c + 2 * MOVES[k, 1] < 2 * cols:
                choices[found] = k
                found += 1
        chance = np.float64(draw(key, np.uint64(2 * junction)) >> np.uint64(11)) / 2.0**53
        if exits == 1 and found > 0 and chance < share:
            k = choices[np.int64(draw(key, np.uint64(2 * junction + 1)) % np.uint64(found))]
            lattice[r + MOVES[k, 0], c + MOVES[k, 1]] = True
