"""Statistics on data with a known answer."""

import numpy as np
import pytest

from indoor_explorers.evaluation.statistics import (
    FEWEST,
    bootstrap_mean,
    curve_band,
    interquartile_mean,
    paired_difference,
)


def test_the_interval_covers_the_true_mean_about_95_times_in_100():
    rng = np.random.default_rng(1)
    covered = 0
    for _ in range(400):
        estimate = bootstrap_mean(rng.gamma(4.0, 10.0, 40), resamples=500)
        covered += estimate.low <= 40.0 <= estimate.high
    assert 0.90 <= covered / 400 <= 0.98


def test_a_planted_paired_difference_is_found_where_unpaired_noise_would_hide_it():
    rng = np.random.default_rng(2)
    difficulty = rng.normal(100, 30, 50)
    baseline = difficulty + rng.normal(0, 2, 50)
    better = difficulty - 3 + rng.normal(0, 2, 50)
    difference = paired_difference(better, baseline)
    assert difference.high < 0
    assert difference.mean == pytest.approx(-3, abs=1)
    assert bootstrap_mean(better).high > bootstrap_mean(baseline).low


def test_no_difference_is_invented():
    rng = np.random.default_rng(3)
    found = 0
    for _ in range(200):
        one, other = rng.normal(50, 10, (2, 30))
        difference = paired_difference(one, other, resamples=500)
        found += not difference.low <= 0 <= difference.high
    assert found <= 24


def test_policies_are_resampled_with_the_same_episodes():
    values = np.random.default_rng(4).normal(10, 3, 20)
    one, other = bootstrap_mean(values), bootstrap_mean(values + 5)
    assert other.low == pytest.approx(one.low + 5)
    assert other.high == pytest.approx(one.high + 5)


def test_too_few_episodes_get_no_interval():
    assert bootstrap_mean(np.arange(FEWEST - 1)) == (1.5, None, None)
    mean, low, high = curve_band(np.ones((FEWEST - 1, 7)))
    assert (mean == 1).all()
    assert np.isnan(low).all()
    assert np.isnan(high).all()


def test_curve_band_equals_the_bootstrap_of_each_step():
    curves = np.random.default_rng(5).random((12, 6)).cumsum(axis=1)
    mean, low, high = curve_band(curves, resamples=1000)
    for t in range(6):
        estimate = bootstrap_mean(curves[:, t], resamples=1000)
        assert (mean[t], low[t], high[t]) == pytest.approx(estimate)


def test_interquartile_mean_drops_the_outer_quarters():
    assert interquartile_mean([0, 2, 3, 1000]) == 2.5
    assert interquartile_mean([5.0]) == 5.0
