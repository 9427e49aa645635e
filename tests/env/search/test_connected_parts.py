"""The largest connected part, against scipy's labels."""

import numpy as np
import pytest

from indoor_explorers.env.search.connected_parts import connected_parts, largest_part


def expected(free):
    labels, sizes = connected_parts(free)
    sizes[0] = 0
    return labels == sizes.argmax() if sizes.max() > 0 else np.zeros_like(free)  # labels are in reading order


@pytest.mark.parametrize("seed", range(200))
def test_the_largest_part_is_that_of_scipy_and_the_first_of_equal_ones(seed):
    rng = np.random.default_rng(seed)
    free = rng.random(rng.integers(1, 24, 2)) < rng.random()
    assert np.array_equal(largest_part(free), expected(free))


@pytest.mark.parametrize(
    "rows",
    [
        ["#"],
        ["."],
        ["..#..", "#.#.#"],
        [".#.#.#.", ".#.#.#.", "......."],
        ["#######", "#.....#", "#.###.#", "#.#.#.#", "#.#...#", "#.#####", "#......"],
    ],
    ids=["solid", "one", "equal", "comb", "spiral"],
)
def test_shapes(rows):
    free = np.array([[cell == "." for cell in row] for row in rows])
    assert np.array_equal(largest_part(free), expected(free))
