"""Shares of episodes that succeeded: exact intervals, and the paired test."""

import numpy as np
import pytest
from scipy import stats

from indoor_explorers.evaluation.statistics import sign_flip_test, success_share, success_test


@pytest.mark.parametrize(("hits", "count"), [(0, 5), (5, 5), (27, 30), (30, 30), (1, 40)])
def test_the_interval_is_that_of_clopper_and_pearson(hits, count):
    share = success_share([True] * hits + [False] * (count - hits))
    low, high = stats.binomtest(hits, count).proportion_ci(0.95, "exact")
    assert tuple(share) == pytest.approx((hits / count, low, high))


def test_all_of_thirty_is_compatible_with_88_percent_and_few_episodes_have_no_interval():
    assert success_share([True] * 30).low == pytest.approx(0.884, abs=5e-4)
    assert success_share([True] * 4) == (1.0, None, None)
    assert np.isnan(success_share([]).mean)


def test_the_test_is_mcnemars():
    ours, theirs = np.array([1] * 20 + [0] * 10), np.array([1] * 12 + [0] * 8 + [1] * 2 + [0] * 8)
    assert success_test(ours, theirs) == pytest.approx(stats.binomtest(2, 10).pvalue)
    assert success_test(ours[:12], theirs[:12]) == 1.0
    assert success_test(ours[18:], theirs[18:], np.arange(12)) == pytest.approx(
        sign_flip_test(ours[18:] - theirs[18:], np.arange(12))
    )


def test_episodes_on_one_map_are_not_counted_as_independent():
    maps = np.repeat(np.arange(6), 10)
    ours, theirs = np.ones(60), np.tile([1] * 8 + [0] * 2, 6)
    assert success_test(ours, theirs) < 0.001
    assert success_test(ours, theirs, maps) == 2 / 64
