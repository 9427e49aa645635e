from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.statistics import ratio_of_means


def test_it_is_the_ratio_of_the_means_and_not_the_mean_of_ratios() -> None:
    found = ratio_of_means([10, 20, 30, 40, 50], [5, 20, 10, 20, 20])
    assert found.mean == pytest.approx(2.0)
    assert found.low is not None
    assert found.high is not None
    assert found.low < 2.0 < found.high


def test_what_a_task_gives_to_both_cancels() -> None:
    below = np.array([1.0, 10, 100, 1000, 10_000, 7])
    assert ratio_of_means(3 * below, below) == pytest.approx((3.0, 3.0, 3.0))


def test_the_interval_covers_a_planted_ratio() -> None:
    rng = np.random.default_rng(5)
    covered = 0
    for _ in range(200):
        task = rng.gamma(20, 2, 30)
        found = ratio_of_means(task * rng.gamma(16, 2 / 16, 30), task * rng.gamma(16, 1 / 16, 30), resamples=500)
        assert found.low is not None
        assert found.high is not None
        covered += found.low <= 2.0 <= found.high
    assert 0.88 <= covered / 200 <= 0.99


def test_few_tasks_get_no_interval_and_nothing_is_divided_by_zero() -> None:
    assert ratio_of_means([4, 6], [2, 3]) == (2.0, None, None)
    with pytest.raises(InputError, match="above 0"):
        ratio_of_means([4, 6], [2, 0])
    with pytest.raises(InputError, match="above 0"):
        ratio_of_means([], [])
