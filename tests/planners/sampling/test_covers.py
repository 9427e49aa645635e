from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.planners.sampling.covers import distinct, greedy_cover
from indoor_explorers.planners.sampling.samples import border_cells, merged


def some_sets(seed: int) -> list[set[int]]:
    rng = np.random.default_rng(seed)
    return [set(rng.choice(150, int(rng.integers(1, 40)), replace=False).tolist()) for _ in range(30)]


def as_bits(sets: list[set[int]]) -> np.ndarray:
    bits = np.zeros((len(sets), 3), np.uint64)
    for k, members in enumerate(sets):
        for member in members:
            bits[k, member // 64] |= np.uint64(1) << np.uint64(member % 64)
    return bits


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("least", [1, 4])
def test_covers_take_the_ranked_pick_of_each_round(seed: int, least: int) -> None:
    sets = some_sets(seed)
    ranks = np.random.default_rng(seed).integers(3, size=60)
    weights = np.random.default_rng(seed).random(len(sets)) + 0.1
    picks, added = greedy_cover(as_bits(sets), weights, ranks, least)
    left = set().union(*sets)
    for place, (pick, gain) in enumerate(zip(picks.tolist(), added.tolist(), strict=True)):
        gains = [len(members & left) for members in sets]
        worth = sorted((w * count for w, count in zip(weights, gains, strict=True) if count >= least), reverse=True)
        assert gain == gains[pick]
        assert weights[pick] * gain == pytest.approx(worth[min(int(ranks[place]), len(worth) - 1)])
        left -= sets[pick]
    assert max(len(members & left) for members in sets) < least


def test_a_cover_is_as_long_as_the_ranks() -> None:
    assert len(greedy_cover(as_bits(some_sets(0)), np.ones(30), np.zeros(4, np.int64), 1)[0]) == 4


def test_nothing_to_see_needs_no_picks() -> None:
    picks, _ = greedy_cover(np.zeros((5, 2), np.uint64), np.ones(5), np.zeros(4, np.int64), 1)
    assert len(picks) == 0


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("overlap", [0.0, 0.3, 1.0])
def test_distinct_views_have_little_in_common(seed: int, overlap: float) -> None:
    sets, chosen = some_sets(seed), list[int]()
    for k, members in enumerate(sets):
        if all(len(members & sets[other]) <= overlap * len(members) for other in chosen):
            chosen.append(k)
    assert distinct(as_bits(sets), overlap, 30).tolist() == chosen
    assert distinct(as_bits(sets), overlap, 3).tolist() == chosen[:3]


def test_near_candidates_are_merged() -> None:
    cells = np.array([0, 1, 2, 3, 4, 9, 30], np.int32)
    assert cells[merged(cells, 3.0, 10, len(cells))].tolist() == [0, 3, 9, 30]
    assert merged(cells[:0], 3.0, 10, 5).tolist() == []


def test_border_cells_are_unknown_beside_free() -> None:
    belief = np.array([[1, 0, 0, 1], [2, 0, 0, 0]], np.uint8)
    whole = np.array([0, 0]), np.array([2, 4])
    assert border_cells(belief, *whole).tolist() == [1, 2, 7]
    assert border_cells(belief, np.array([0, 0]), np.array([1, 2])).tolist() == [1]
