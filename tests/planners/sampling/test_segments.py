from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.planners.sampling.segments import ALL_KNOWN, BLOCKED, entries, trace


def touched(a: np.ndarray, b: np.ndarray) -> set[tuple[int, int]]:
    """The cells that a segment runs through, by sampling it densely."""
    points = a + (b - a) * np.linspace(0.0, 1.0, 4001)[:, None]
    return {(int(r), int(c)) for r, c in np.floor(points)}


@pytest.mark.parametrize("seed", range(40))
def test_flights_agree_with_dense_sampling(seed: int) -> None:
    rng = np.random.default_rng(seed)
    belief = rng.choice([UNKNOWN, FREE, OCCUPIED], (9, 11), p=[0.2, 0.7, 0.1]).astype(np.uint8)
    a, b = rng.random((2, 2)) * belief.shape
    belief[tuple(np.floor(a).astype(int))] = FREE
    values = {int(belief[cell]) for cell in touched(a, b)}
    answer = trace(belief, *a, *b)
    assert (answer == BLOCKED) == (OCCUPIED in values)
    if answer != BLOCKED:
        assert (answer == ALL_KNOWN) == (UNKNOWN not in values)
    if answer >= 0:
        row, col = divmod(answer, belief.shape[1])
        assert belief[row, col] == FREE
        around = np.pad(belief, 1, constant_values=OCCUPIED)
        assert UNKNOWN in around[[row, row + 2, row + 1, row + 1], [col + 1, col + 1, col, col + 2]]


def test_leaving_the_map_is_blocked() -> None:
    assert trace(np.ones((4, 4), np.uint8), 1.5, 1.5, 1.5, 4.5) == BLOCKED


def test_touching_corners_let_nobody_through() -> None:
    belief = np.array([[1, 2], [2, 1]], np.uint8)
    assert trace(belief, 0.5, 0.5, 1.5, 1.5) == BLOCKED


def test_only_first_entries_count() -> None:
    belief = np.array([[1, 1, 0, 0, 1, 1, 0]], np.uint8)
    vertices = np.array([[0.5, 0.5], [0.5, 2.5], [0.5, 4.5], [0.5, 6.5]])
    assert entries(belief, vertices, np.array([-1, 0, 1, 2])).tolist() == [1]
