"""How often intervals and bands hold the truth, over data drawn again and again."""

import numpy as np
import pytest

from indoor_explorers.evaluation.statistics import bootstrap_mean, curve_band, resampled_weights
from indoor_explorers.evaluation.statistics.resampling import SmallSample


def coverage(values, truth, maps=None):
    """Return the share of the rows of (N, E) values whose interval of the mean holds the truth."""
    weights = np.concatenate(list(resampled_weights(values.shape[1], 1000, maps)))
    low, high = np.quantile(values @ weights.T, SmallSample.of(values.shape[1], maps).tails, axis=1)
    return float(((low <= truth) & (truth <= high)).mean())


def on_maps(rng, maps, runs, between=1.0, within=1.0):
    """Return (runs, E) values: an effect for each map, and noise."""
    effects = rng.normal(0, between, (runs, maps.max() + 1))
    return effects[:, maps] + rng.normal(0, within, (runs, len(maps)))


def test_what_is_simulated_here_is_the_shipped_interval():
    values = np.random.default_rng(0).normal(0, 1, 20)
    maps = np.arange(20) // 3
    for labels in (None, maps):
        estimate = bootstrap_mean(values, resamples=1000, maps=labels)
        assert coverage(values[None], estimate.low + 1e-9, labels) == 1
        assert coverage(values[None], estimate.low - 1e-9, labels) == 0


@pytest.mark.parametrize("count", [5, 8, 20, 40])
def test_intervals_of_normal_values_hold_the_mean_about_95_times_in_100(count):
    values = np.random.default_rng(count).normal(50, 10, (1500, count))
    assert 0.91 <= coverage(values, 50) <= 0.97


def test_plain_percentiles_of_few_values_would_hold_the_mean_less_often():
    values = np.random.default_rng(5).normal(50, 10, (1500, 5))
    weights = np.concatenate(list(resampled_weights(5, 1000)))
    low, high = np.quantile(values @ weights.T, (0.025, 0.975), axis=1)
    assert ((low <= 50) & (high >= 50)).mean() <= 0.87


@pytest.mark.parametrize(("count", "least"), [(5, 0.85), (20, 0.90), (40, 0.92)])
def test_intervals_of_skewed_values_hold_the_mean_a_little_less_often(count, least):
    values = np.random.default_rng(count).gamma(4.0, 10.0, (1500, count))
    assert least <= coverage(values, 40) <= 0.96


@pytest.mark.parametrize(("count", "each"), [(5, 10), (8, 10), (20, 5)])
def test_where_maps_differ_only_drawing_maps_covers(count, each):
    maps = np.repeat(np.arange(count), each)
    values = on_maps(np.random.default_rng(count), maps, 1000)
    assert 0.92 <= coverage(values, 0, maps) <= 0.98
    assert coverage(values, 0) <= 0.80


def test_where_maps_are_alike_drawing_them_is_cautious():
    maps = np.repeat(np.arange(20), 10)
    assert 0.96 <= coverage(on_maps(np.random.default_rng(1), maps, 500, between=0), 0, maps) <= 1


@pytest.mark.parametrize(("count", "each", "least"), [(2, 20, 0.92), (3, 5, 0.91), (4, 2, 0.80)])
def test_on_fixed_maps_the_interval_is_about_their_own_mean(count, each, least):
    maps = np.repeat(np.arange(count), each)
    values = 5.0 * maps + np.random.default_rng(count).normal(0, 1, (1000, len(maps)))
    assert least <= coverage(values, 5.0 * maps.mean(), maps) <= 0.97


@pytest.mark.parametrize(("count", "least"), [(5, 0.84), (10, 0.88), (20, 0.91), (40, 0.92)])
def test_a_band_holds_whole_curves_where_intervals_of_each_step_do_not(count, least):
    rng = np.random.default_rng(count)
    weights = np.concatenate(list(resampled_weights(count, 500)))
    inside, pointwise, runs = 0, 0, 250
    for curves in rng.normal(0, 1, (runs, count, 25)).cumsum(axis=2):
        _, low, high = curve_band(curves, resamples=500)
        inside += bool(((low <= 0) & (high >= 0)).all())
        low, high = np.quantile(weights @ curves, SmallSample.of(count, None).tails, axis=0)
        pointwise += bool(((low <= 0) & (high >= 0)).all())
    assert least <= inside / runs <= 0.98
    assert pointwise / runs <= inside / runs - 0.1


def test_a_band_over_sampled_maps_holds_curves_that_differ_by_map():
    maps, rng = np.repeat(np.arange(12), 5), np.random.default_rng(5)
    inside, ignoring, runs = 0, 0, 200
    for _ in range(runs):
        curves = (rng.normal(0, 1, (12, 15))[maps] + rng.normal(0, 0.5, (60, 15))).cumsum(axis=1)
        for labels in (maps, None):
            _, low, high = curve_band(curves, maps=labels, resamples=500)
            held = bool(((low <= 0) & (high >= 0)).all())
            inside, ignoring = inside + (held and labels is not None), ignoring + (held and labels is None)
    assert inside / runs >= 0.90
    assert ignoring / runs <= 0.60


def test_rare_failures_make_intervals_of_means_too_narrow_as_the_document_says():
    rng, held = np.random.default_rng(3), 0
    for _ in range(200):
        times = np.where(rng.random(30) < 0.02, 400, rng.normal(55, 9, 30))
        _, low, high = bootstrap_mean(times, resamples=500)
        held += low <= 0.98 * 55 + 0.02 * 400 <= high
    assert held / 200 < 0.6
