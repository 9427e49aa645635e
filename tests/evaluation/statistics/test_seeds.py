"""Means over trainings and episodes: the spread of both counts."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from indoor_explorers.evaluation.statistics import difference_of_seeds, mean_of_seeds


def test_a_difference_is_that_of_the_means_with_the_spread_of_seeds_and_episodes():
    ours = np.array([[4.0, 6.0, 8.0, 6.0, 6.0], [6.0, 8.0, 10.0, 8.0, 8.0]])  # means 6 and 8: variance 2
    theirs = np.array([[1.0, 2.0, 3.0, 2.0, 2.0], [1.0, 2.0, 3.0, 2.0, 2.0]])  # means 2 and 2: variance 0
    # by episode 5-1, 7-2, 9-3, 7-2, 7-2: 4, 5, 6, 5, 5, variance 0.5
    total, spread = 0.5 / 5 + 2.0 / 2, (0.5 / 5) ** 2 / 4 + (2.0 / 2) ** 2 / 1
    reach = math.sqrt(total) * stats.t.ppf(0.975, total**2 / spread)
    assert difference_of_seeds(ours, theirs) == pytest.approx((5.0, 5.0 - reach, 5.0 + reach))


def test_one_training_or_few_episodes_have_no_interval():
    values = np.arange(10.0).reshape(2, 5)
    assert mean_of_seeds(values).low is not None
    assert mean_of_seeds(values[:1]) == (2.0, None, None)
    assert mean_of_seeds(values[:, :4]) == (4.0, None, None)
    assert difference_of_seeds(values, values[:1]) == (2.5, None, None)


def test_values_that_are_all_alike_have_an_interval_without_width():
    assert difference_of_seeds(np.full((2, 5), 3.0), np.full((3, 5), 2.0)) == (1.0, 1.0, 1.0)


def test_intervals_hold_the_truth_about_as_often_as_they_say():
    rng, held, rounds = np.random.default_rng(0), 0, 400
    for _ in range(rounds):
        maps = rng.normal(0, 8, 50)
        ours, theirs = (maps + rng.normal(0, 2, (3, 1)) + rng.normal(0, 4, (3, 50)) for _ in range(2))
        _, low, high = difference_of_seeds(ours, theirs)
        assert low is not None
        assert high is not None
        held += low <= 0 <= high
    assert 0.92 <= held / rounds <= 1.0
