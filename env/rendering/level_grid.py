"""How the levels of a map lie in a picture: in a grid beside each other, level 0 first, with room for names above.

The page of a report does the same in ``replay_levels.js``.
"""

from __future__ import annotations

from math import ceil
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.levels import Levels


class LevelGrid(NamedTuple):
    """Where the cells of a plane are in its picture; a map of one level is its own picture."""

    levels: Levels
    columns: int

    @classmethod
    def of(cls, levels: Levels, most: float = np.inf) -> LevelGrid:
        """Return the grid of the shortest longer side among those at most ``most`` cells wide, or else one column."""
        grids = [cls(levels, columns) for columns in range(1, levels.number + 1)]
        return min([grid for grid in grids if grid.shape[1] <= most] or grids[:1], key=lambda grid: max(grid.shape))

    @property
    def gap(self) -> int:
        """Cells above each level and between columns; 0 where there is one level."""
        level = self.levels
        return max(2, ceil(max(level.height, level.width) / 10)) if level.number > 1 else 0

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the picture, in cells."""
        rows = ceil(self.levels.number / self.columns)
        return rows * (self.levels.height + self.gap), self.columns * (self.levels.width + self.gap) - self.gap

    def corner(self, level: Any) -> tuple[Any, Any]:
        """Return row and column in the picture of the first cell of a level, or of an array of levels."""
        row, col = level // self.columns, level % self.columns
        return row * (self.levels.height + self.gap) + self.gap, col * (self.levels.width + self.gap)

    def places(self, cells: NDArray[Any]) -> NDArray[Any]:
        """Return where cells (..., 2) of the plane are in the picture, (..., 2)."""
        voxels = self.levels.voxels(cells)
        return np.asarray(voxels[..., 1:] + np.stack(self.corner(voxels[..., 0]), axis=-1))

    def laid_out(self, plane: NDArray[Any], between: Any) -> NDArray[Any]:
        """Return the picture (h, w, ...) of a plane (P, W, ...), with ``between`` around the levels."""
        if self.levels.number == 1:
            return plane
        (number, height, width), picture = self.levels, np.full((*self.shape, *plane.shape[2:]), between, plane.dtype)
        for level in range(number):
            (row, col), first = self.corner(level), level * (height + 1)
            picture[row : row + height, col : col + width] = plane[first : first + height]
        return picture
