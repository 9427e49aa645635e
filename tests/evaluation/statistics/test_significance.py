"""P-values by hand, against scipy, and under the null hypothesis."""

import numpy as np
import pytest
from scipy import stats

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.statistics import (
    all_pairs_test,
    holm,
    sign_flip_test,
    smallest_detectable_difference,
)
from tests.marks import slow


@pytest.mark.parametrize(
    ("differences", "p"),
    [
        ([1, 2, 3], 2 / 8),
        ([1, 2, -3], 8 / 8),
        ([5, 5, 5, -1], 4 / 16),
        ([-1, -2, -3, -4, -5], 2 / 32),
        ([0, 0, 0], 1),
        ([4], 1),
        ([0.1, 0.2, -0.3], 1),
    ],
)
def test_exact_p_values_of_tiny_samples(differences, p):
    assert sign_flip_test(differences) == p
    assert sign_flip_test(np.negative(differences)) == p


@pytest.mark.parametrize("count", [5, 9, 14])
def test_exact_p_values_are_those_of_scipy(count):
    differences = np.random.default_rng(count).normal(0.4, 1, count)
    theirs = stats.permutation_test(
        (differences,), np.mean, permutation_type="samples", n_resamples=2**count, batch=1024
    )
    assert sign_flip_test(differences) == pytest.approx(theirs.pvalue)


def test_random_flips_come_close_to_the_normal_approximation():
    differences = np.random.default_rng(3).normal(0.15, 1, 200)
    z = differences.sum() / np.sqrt((differences**2).sum())
    assert sign_flip_test(differences) == pytest.approx(2 * stats.norm.sf(abs(z)), abs=0.015)
    assert sign_flip_test(differences) == sign_flip_test(differences)


def test_random_p_values_are_never_0():
    assert sign_flip_test(np.ones(50)) == 1 / 10_001


def test_a_planted_difference_is_found():
    assert sign_flip_test(np.random.default_rng(4).normal(-3, 4, 40)) < 0.001


def test_maps_are_the_units_where_they_are_a_sample():
    effects = np.array([1.0, 2, 3, 4, 5, 6])
    noise = np.tile([-0.5, 0.5], 6)
    assert sign_flip_test(np.repeat(effects, 2) + noise, np.repeat(np.arange(6), 2)) == 2 / 64


def test_maps_that_differ_do_not_make_a_difference_where_episodes_alone_would():
    rng = np.random.default_rng(5)
    maps = np.repeat(np.arange(8), 10)
    by_map = by_episode = 0
    for _ in range(100):
        differences = rng.normal(0, 1, 8)[maps] + rng.normal(0, 0.5, 80)
        by_map += sign_flip_test(differences, maps) <= 0.05
        by_episode += sign_flip_test(differences) <= 0.05
    assert by_map <= 12
    assert by_episode >= 40


def test_the_test_is_about_the_mean_over_episodes_however_many_a_map_has():
    maps = np.array([0] * 7 + list(range(1, 21)))
    differences = np.where(maps == 0, 2.0, -0.7)
    assert differences.sum() == pytest.approx(0)
    assert sign_flip_test(differences, maps) == 1.0  # the mean of the maps' means is -0.6
    assert all_pairs_test(np.stack([differences, np.zeros(27)], axis=1), maps).adjusted_p[0, 1] == 1.0
    assert smallest_detectable_difference(differences, maps=maps) > 0.5


def test_episodes_are_the_units_on_few_maps():
    differences = np.random.default_rng(6).normal(1, 1, 12)
    assert sign_flip_test(differences, np.arange(12) % 3) == sign_flip_test(differences)


def test_no_pairs_are_refused():
    with pytest.raises(InputError, match="at least one paired difference"):
        sign_flip_test([])


def test_holm_by_hand():
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([0.6, 0.5]) == pytest.approx([1, 1])
    assert holm([0.02]).tolist() == [0.02]
    assert holm([]).tolist() == []


def test_holm_keeps_the_order_of_p_values():
    p = np.random.default_rng(7).random(30) ** 3
    assert (np.diff(holm(p)[np.argsort(p)]) >= 0).all()
    assert (holm(p) >= p).all()


@pytest.mark.parametrize("p", [[1.2], [-0.1], [np.nan], [[0.5]]])
def test_what_is_no_p_value_is_refused(p):
    with pytest.raises(InputError, match="p-values"):
        holm(p)


@pytest.mark.parametrize("count", [8, *slow(20)])
def test_a_family_invents_a_difference_at_most_5_times_in_100(count):
    rng = np.random.default_rng(count)
    invented, runs = 0, 400
    for _ in range(runs):
        values = rng.gamma(4.0, 10.0, (count, 1)) + rng.normal(0, 5, (count, 7))
        p = [sign_flip_test(values[:, k] - values[:, 0]) for k in range(1, 7)]
        invented += bool((holm(p) <= 0.05).any())
    assert invented / runs <= 0.05 + 3 * np.sqrt(0.05 * 0.95 / runs)


def test_the_test_of_two_policies_is_the_sign_flip_test():
    for units in (8, 30):
        values = np.random.default_rng(units).gamma(4, 5, (units, 2))
        found = all_pairs_test(values)
        assert found.adjusted_p[0, 1] == found.adjusted_p[1, 0] == sign_flip_test(values[:, 0] - values[:, 1])


def test_policies_with_the_same_values_count_as_one_when_all_pairs_are_tested():
    values = np.random.default_rng(0).gamma(4, 5, (12, 3)) + [0.0, 4.0, 9.0]
    alone, doubled = all_pairs_test(values), all_pairs_test(values[:, [0, 1, 2, 2, 0]])
    np.testing.assert_array_equal(doubled.adjusted_p[:3, :3], alone.adjusted_p)
    assert doubled.adjusted_p[0, 4] == 1.0
    assert doubled.level == alone.level


def test_a_true_difference_is_still_found_beside_noisy_policies():
    rng = np.random.default_rng(2)
    values = rng.normal(50, 3, (30, 6)) + [0, 4, 4, 0, 0, 40] + [0, 0, 0, 30, 0, 0]
    values[:, 4] += rng.normal(10, 30, 30)
    assert (all_pairs_test(values).adjusted_p[0, [1, 2, 3, 5]] <= 0.05).all()
