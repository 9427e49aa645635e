"""Effect sizes by hand, and the power at the smallest detectable difference."""

import math

import numpy as np
import pytest
from scipy import stats

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.statistics import effect_size, sign_flip_test, smallest_detectable_difference


def test_the_effect_size_by_hand():
    assert effect_size([1, 2, 3]) == pytest.approx(2 * math.gamma(1) / math.gamma(0.5))
    assert effect_size([-1, -2, -3]) == -effect_size([1, 2, 3])
    many = np.random.default_rng(1).normal(2, 4, 500)
    assert effect_size(many) == pytest.approx(many.mean() / many.std(ddof=1), rel=0.002)


def test_the_effect_size_of_few_pairs_is_unbiased():
    rng = np.random.default_rng(2)
    assert np.mean([effect_size(rng.normal(0.8, 1, 6)) for _ in range(4000)]) == pytest.approx(0.8, abs=0.03)


def test_the_effect_size_where_there_is_no_spread():
    assert effect_size([0, 0, 0, 0]) == 0
    assert math.isnan(effect_size([0.1, 0.1, 0.1]))
    assert math.isnan(effect_size([1, 2]))


def spread(count):
    values = np.random.default_rng(3).normal(0, 1, count)
    return (values - values.mean()) / values.std(ddof=1)


def test_the_smallest_detectable_difference_by_hand():
    expected = (2.262157 + 0.883404) * 1 / math.sqrt(10)
    assert smallest_detectable_difference(spread(10)) == pytest.approx(expected, rel=1e-6)
    assert smallest_detectable_difference(7 * spread(10) + 3) == pytest.approx(7 * expected, rel=1e-6)
    assert smallest_detectable_difference(np.zeros(10)) == 0


@pytest.mark.parametrize("count", [6, 10, 40])
def test_the_t_test_finds_it_with_that_power(count):
    shift = smallest_detectable_difference(spread(count), power=0.9)
    limit = stats.t.ppf(0.975, count - 1)
    assert stats.nct.sf(limit, count - 1, shift * math.sqrt(count)) == pytest.approx(0.9, abs=0.01)


@pytest.mark.parametrize("count", [8, 20])
def test_the_sign_flip_test_finds_it_about_80_times_in_100(count):
    rng, shift = np.random.default_rng(count), smallest_detectable_difference(spread(count))
    found = np.mean([sign_flip_test(rng.normal(shift, 1, count)) <= 0.05 for _ in range(500)])
    assert 0.74 <= found <= 0.86


def test_too_few_units_detect_nothing():
    assert smallest_detectable_difference([1.0]) == math.inf
    assert smallest_detectable_difference(spread(5)) == math.inf
    assert smallest_detectable_difference(spread(6)) < math.inf
    assert smallest_detectable_difference(spread(8), level=0.005) == math.inf


def test_episodes_on_the_same_maps_detect_less():
    maps = np.repeat(np.arange(8), 10)
    differences = np.random.default_rng(4).normal(0, 1, 8)[maps] + np.random.default_rng(5).normal(0, 0.3, 80)
    assert smallest_detectable_difference(differences, maps=maps) > 1.5 * smallest_detectable_difference(differences)


def test_what_is_no_probability_is_refused():
    with pytest.raises(InputError, match="between 0 and 1"):
        smallest_detectable_difference(spread(10), power=80)
