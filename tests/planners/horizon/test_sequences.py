from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

from indoor_explorers.env.arrays import Belief
from indoor_explorers.env.grid import UNKNOWN
from indoor_explorers.planners.horizon.cellsets import packed
from indoor_explorers.planners.horizon.sequences import best_first, gains_alone, isolation_weights


@pytest.mark.parametrize("seed", range(5))
def test_a_wide_beam_finds_the_best_sequence(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count = 5
    sets = rng.random((count, 100)) < 0.3
    points = rng.integers(0, 30, (count + 1, 2))
    steps = np.abs(points[:, None] - points[None]).sum(axis=2).astype(np.float64)
    weights, shares = np.pad(rng.random(100), (0, 28)), rng.random(count)

    def value(order: tuple[int, ...]) -> float:
        total, time, at, seen = 0.0, 0.0, count, np.zeros(100, np.bool_)
        for k in order:
            time, at = time + steps[at, k], k
            total += float(shares[k] * weights[:100][sets[k] & ~seen].sum() * np.exp(-0.05 * time))
            seen |= sets[k]
        return total

    bits = np.stack([packed(one) for one in sets])
    expected = max(permutations(range(count), 3), key=value)[0]
    found = best_first(steps[count, :count], steps[:count, :count], bits, weights, shares, 0.05, 3, 1000)
    assert found == expected
    assert gains_alone(bits, weights) == pytest.approx([weights[:100][one].sum() for one in sets])


def test_isolation_counts_what_is_known_around(belief: Belief) -> None:
    weights = isolation_weights(belief, 2, 8.0)
    wide = np.pad(belief == UNKNOWN, 2)
    for row, col in np.ndindex(*belief.shape):
        assert weights[row, col] == pytest.approx(1 + 8 * (1 - wide[row : row + 5, col : col + 5].mean()))
