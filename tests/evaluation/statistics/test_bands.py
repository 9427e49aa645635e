"""Simultaneous bands of mean curves: width, steps without spread, blocks of steps."""

import numpy as np
import pytest
from scipy import stats

from indoor_explorers.evaluation.statistics import FEWEST, bootstrap_mean, curve_band, curve_bands


def curves(count=12, steps=30):
    rates = np.random.default_rng(5).gamma(8.0, 0.0125, (count, 1))
    return 1 - np.exp(-rates * np.arange(steps))


def test_too_few_episodes_get_no_band():
    mean, low, high = curve_band(np.ones((FEWEST - 1, 7)))
    assert (mean == 1).all()
    assert np.isnan(low).all()
    assert np.isnan(high).all()


def test_a_band_lies_around_the_mean_and_is_wider_than_the_interval_of_a_step():
    data = np.random.default_rng(6).normal(0, 1, (40, 30)).cumsum(axis=1)
    mean, low, high = curve_band(data)
    assert mean == pytest.approx(data.mean(axis=0))
    assert high - mean == pytest.approx(mean - low)
    for t in (0, 10, 29):
        estimate = bootstrap_mean(data[:, t])
        assert high[t] - low[t] > 1.2 * (estimate.high - estimate.low)


def test_one_step_has_the_width_of_a_t_interval():
    data = np.random.default_rng(7).normal(0, 1, (10, 1))
    _, low, high = curve_band(data, resamples=20_000)
    expected = 2 * stats.t.ppf(0.975, 9) * stats.sem(data[:, 0])
    assert high[0] - low[0] == pytest.approx(expected, rel=0.06)


def test_steps_without_spread_carry_no_width_and_change_nothing():
    moving = curves()
    still = np.full((12, 5), 1 / 3)
    _, low, high = curve_band(np.hstack((still, moving[:, 1:], still)))
    assert (low[:5] == high[:5]).all()
    assert (low[-5:] == high[-5:]).all()
    assert high[5:-5] == pytest.approx(curve_band(moving[:, 1:])[2])


def test_curves_that_are_all_alike_have_a_band_without_width():
    mean, low, high = curve_band(np.tile(np.linspace(0, 1, 9), (6, 1)))
    assert (low == mean).all()
    assert (high == mean).all()


def test_blocks_of_steps_make_no_difference(monkeypatch):
    whole = curve_band(curves())
    monkeypatch.setattr("indoor_explorers.evaluation.statistics.bands.IN_MEMORY", 2000 * 7)
    assert np.stack(curve_band(curves())) == pytest.approx(np.stack(whole))


def test_bands_are_the_same_every_time():
    assert (np.stack(curve_band(curves())) == np.stack(curve_band(curves()))).all()


@pytest.mark.parametrize("count", [FEWEST - 1, 40])
def test_bands_from_one_set_of_resamples_are_those_of_each_alone(count):
    one, other = (np.random.default_rng(seed).random((count, 9)).cumsum(axis=1) for seed in (1, 2))
    side_by_side = np.split(np.concatenate((one, other), axis=1), 2, axis=1)
    for found, curves in zip(curve_bands(side_by_side), (one, other), strict=True):
        np.testing.assert_allclose(found, curve_band(curves), rtol=1e-12)
    assert curve_bands([]) == []
