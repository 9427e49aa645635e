from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env.search.bitsets import around, hash_keys, packed, unpacked


@pytest.mark.parametrize("shape", [(1, 1), (4, 5), (8, 8), (9, 15)])
def test_packing_keeps_every_cell(shape: tuple[int, int]) -> None:
    mask = np.random.default_rng(0).random(shape) < 0.4
    bits = packed(mask)
    assert np.array_equal(unpacked(bits, mask.size), mask.ravel())
    for cell in range(mask.size):
        assert bool(int(bits[cell // 64]) >> (cell % 64) & 1) == mask.flat[cell]


def test_around_lists_the_neighbours_on_the_map() -> None:
    cells = around((3, 4))
    assert set(cells[5][cells[5] >= 0].tolist()) == {0, 1, 2, 4, 6, 8, 9, 10}
    assert set(cells[0][cells[0] >= 0].tolist()) == {1, 4, 5}


def test_hash_keys_are_fixed_and_distinct() -> None:
    assert len(set(hash_keys(500).tolist())) == 500
    assert np.array_equal(hash_keys(10), hash_keys(500)[:10])
