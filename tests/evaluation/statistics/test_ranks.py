"""Ranks count the policies that are shown to be better."""

import numpy as np

from indoor_explorers.evaluation.statistics import tied_ranks


def paired(rng, *means, episodes=40, spread=1.0):
    """(E, K) values of policies with these means on the same tasks."""
    tasks = rng.normal(100.0, 20.0, episodes)
    return np.stack([tasks + mean + rng.normal(0.0, spread, episodes) for mean in means], axis=1)


def test_clear_differences_give_all_ranks_and_none_gives_ties():
    rng = np.random.default_rng(1)
    assert tied_ranks(paired(rng, 20.0, 0.0, 10.0)) == [3, 1, 2]
    assert tied_ranks(paired(rng, 0.0, 0.0, 0.0)) == [1, 1, 1]


def test_two_that_are_not_told_apart_share_a_rank_behind_a_better_one():
    assert tied_ranks(paired(np.random.default_rng(2), 10.0, 10.0, 0.0)) == [2, 2, 1]


def test_larger_may_be_better_and_one_policy_is_first():
    values = paired(np.random.default_rng(3), 20.0, 0.0)
    assert tied_ranks(values, lower_is_better=False) == [1, 2]
    assert tied_ranks(values[:, :1]) == [1]


def test_equal_values_tie():
    values = paired(np.random.default_rng(4), 0.0)
    assert tied_ranks(np.concatenate([values, values], axis=1)) == [1, 1]


def test_episodes_on_one_map_count_as_one():
    values = paired(np.random.default_rng(5), 3.0, 0.0, episodes=24)
    assert tied_ranks(values) == [2, 1]
    assert tied_ranks(values, np.repeat(["a", "b", "c", "d"], 6)) == [2, 1]  # few maps: for these alone
