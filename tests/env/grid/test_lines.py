"""Lines between cells."""

from itertools import product

import numpy as np

from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.grid.lines import obstacles_on_line


def on_line(start: tuple[int, int], end: tuple[int, int]) -> list[tuple[int, int]]:
    """Return the cells of the line after the first: those nearest to it, of two as near the one farther from there."""
    (row, col), (to_row, to_col) = start, end
    length = max(abs(to_row - row), abs(to_col - col))

    def at(k: int, first: int, last: int) -> int:
        away = (2 * k * abs(last - first) + length) // (2 * length)
        return first + (away if last > first else -away)

    return [(at(k, row, to_row), at(k, col, to_col)) for k in range(1, length + 1)]


def test_every_cell_of_every_line_counts_once_and_no_other_does() -> None:
    for start, end in product([(4, 4), (0, 2)], product(range(9), range(9))):
        along = on_line(start, end)
        alone = np.full((9, 9), FREE, np.uint8)
        counted = []
        for cell in product(range(9), range(9)):
            alone[cell] = OCCUPIED
            counted += [cell] * obstacles_on_line(alone, *start, *end)
            alone[cell] = FREE
        assert sorted(counted) == sorted(along)
