"""Means, interquartile means and paired differences on data with a known answer."""

import numpy as np
import pytest
from scipy import stats

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.statistics import (
    FEWEST,
    bootstrap_mean,
    bootstrap_means,
    interquartile_mean,
    paired_difference,
)
from indoor_explorers.evaluation.statistics.means import means_of_measured


def test_a_planted_paired_difference_is_found_where_unpaired_noise_would_hide_it():
    rng = np.random.default_rng(2)
    difficulty = rng.normal(100, 30, 50)
    baseline = difficulty + rng.normal(0, 2, 50)
    better = difficulty - 3 + rng.normal(0, 2, 50)
    difference = paired_difference(better, baseline)
    assert difference.high < 0
    assert difference.mean == pytest.approx(-3, abs=1)
    assert bootstrap_mean(better).high > bootstrap_mean(baseline).low
    assert difference == bootstrap_mean(better - baseline)


@pytest.mark.parametrize("maps", [None, np.arange(20) // 3, np.arange(20) // 10])
def test_policies_are_resampled_with_the_same_episodes(maps):
    values = np.random.default_rng(4).normal(10, 3, 20)
    one, other = bootstrap_mean(values, maps=maps), bootstrap_mean(values + 5, maps=maps)
    assert other == pytest.approx([bound + 5 for bound in one])
    assert bootstrap_mean(values, maps=maps) == one


def test_columns_get_the_intervals_that_they_get_alone():
    columns = np.random.default_rng(6).normal(10, 3, (15, 3))
    for column, estimate in zip(columns.T, bootstrap_means(columns), strict=True):
        assert list(estimate) == pytest.approx(list(bootstrap_mean(column)))


def test_columns_with_gaps_get_the_means_of_what_was_measured():
    values = np.random.default_rng(6).normal(10, 3, (3, 12))
    values[1, 4], values[2] = np.nan, np.nan
    maps, there = np.arange(12).astype(str), np.arange(12) != 4
    found = means_of_measured(dict(zip("abc", values, strict=True)), maps)
    assert found == {"a": bootstrap_mean(values[0], maps=maps), "b": bootstrap_mean(values[1, there], maps=maps[there])}


def test_too_few_episodes_get_no_interval():
    assert bootstrap_mean(np.arange(FEWEST - 1)) == (1.5, None, None)
    assert paired_difference([3.0], [1.0]) == (2.0, None, None)
    assert np.isnan(bootstrap_mean([]).mean)


def test_values_that_are_all_alike_have_an_interval_without_width():
    assert bootstrap_mean(np.full(11, 5.0)) == (5, 5, 5)


def test_the_interval_of_few_normal_values_is_as_wide_as_the_t_interval():
    values = stats.norm.ppf((np.arange(8) + 0.5) / 8)
    estimate = bootstrap_mean(values)
    low, high = stats.t.interval(0.95, 7, values.mean(), stats.sem(values))
    assert estimate.high - estimate.low == pytest.approx(high - low, rel=0.08)


def test_the_interval_of_many_values_is_the_plain_percentile_interval():
    values = np.random.default_rng(7).gamma(2.0, 5.0, 2000)
    plain = stats.bootstrap((values,), np.mean, method="percentile", n_resamples=4000, batch=400, rng=1)
    low, high = plain.confidence_interval
    estimate = bootstrap_mean(values)
    assert estimate.low == pytest.approx(low, abs=0.04)
    assert estimate.high == pytest.approx(high, abs=0.04)


def test_one_map_for_all_episodes_changes_nothing():
    values = np.random.default_rng(8).normal(10, 3, 12)
    assert bootstrap_mean(values, maps=np.full(12, 7)) == bootstrap_mean(values)
    assert bootstrap_mean(values, maps=np.arange(12)[::-1]) == bootstrap_mean(values)


def test_differences_between_fixed_maps_are_no_uncertainty():
    maps = np.arange(20) // 10
    values = np.where(maps, 100.0, 0.0) + np.tile([-1.0, 1.0], 10)
    within, over = bootstrap_mean(values, maps=maps), bootstrap_mean(values)
    assert 0.5 < within.high - within.low < 2
    assert over.high - over.low > 40


def test_interquartile_mean_drops_the_outer_quarters():
    assert interquartile_mean([0, 2, 3, 1000]) == 2.5
    assert interquartile_mean([5.0]) == 5.0
    assert np.isnan(interquartile_mean([]))
    for count in range(1, 60):
        values = np.random.default_rng(count).gamma(2.0, 5.0, count)
        assert interquartile_mean(values) == stats.trim_mean(values, 0.25)


@pytest.mark.parametrize(
    ("values", "said"),
    [([1.0, np.nan], "finite"), ([1.0, np.inf], "finite"), ([[1.0]], r"\(1, 1\)")],
)
def test_values_that_are_no_numbers_of_episodes_are_refused(values, said):
    with pytest.raises(InputError, match=said):
        bootstrap_mean(values)


def test_values_that_are_no_pairs_are_refused():
    with pytest.raises(InputError, match="3 and 2"):
        paired_difference([1, 2, 3], [1, 2])
