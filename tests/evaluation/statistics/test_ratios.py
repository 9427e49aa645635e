from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.statistics import Block, bootstrap_mean, paired_ratios, ratio_of_means


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


def block(above, below, maps=None):
    labels = np.arange(len(above)) if maps is None else maps
    return Block(np.asarray(above, float), np.asarray(below, float), np.asarray(labels).astype(str))


def drawn(tasks, maps=None, seed=0, columns=2):
    rng = np.random.default_rng(seed)
    below = np.repeat(rng.gamma(20, 2, (tasks, 1)), columns, axis=1)
    return block(below * rng.gamma(30, 0.9 / 30, (tasks, columns)), below, maps)


@pytest.mark.parametrize("maps", [None, np.repeat(range(6), 5), np.repeat(range(3), 10), np.zeros(30)])
def test_on_one_scenario_ratios_are_those_of_the_plain_functions(maps):
    one = drawn(30, maps)
    for k, found in enumerate(paired_ratios([one])):
        above, below = one.above[:, k], one.below[:, k]
        assert found.of_tasks == pytest.approx(bootstrap_mean(above / below, maps=one.maps))
        assert found.of_means == pytest.approx(ratio_of_means(above, below, maps=one.maps))


def test_pooled_ratios_are_plain_ones_over_all_tasks_where_scenarios_have_as_many():
    one, other = drawn(12, seed=1), drawn(12, seed=2)
    above, below = (np.concatenate(pair) for pair in ((one.above, 9 * other.above), (one.below, 9 * other.below)))
    found = paired_ratios([one, block(9 * other.above, 9 * other.below)])
    assert [each.of_tasks.mean for each in found] == pytest.approx((above / below).mean(axis=0))
    assert [each.of_means.mean for each in found] == pytest.approx(above.mean(axis=0) / below.mean(axis=0))


def test_every_scenario_counts_the_same_whatever_its_tasks():
    many, few = (
        block(np.full((40, 1), 20.0), np.full((40, 1), 10.0)),
        block(np.full((5, 1), 30.0), np.full((5, 1), 30.0)),
    )
    (found,) = paired_ratios([many, few])
    assert found.of_tasks == pytest.approx((1.5, 1.5, 1.5))
    assert found.of_means == pytest.approx((50 / 40, 50 / 40, 50 / 40))


def test_scenarios_that_share_their_tasks_tell_no_more_than_one():
    one, other = drawn(30, seed=3), drawn(30, seed=4)
    width = {
        name: [each.of_tasks.high - each.of_tasks.low for each in paired_ratios(blocks)]
        for name, blocks in {"one": [one], "twice": [one, one], "apart": [one, other]}.items()
    }
    assert width["twice"] == pytest.approx(width["one"])
    assert np.mean(width["apart"]) < 0.85 * np.mean(width["one"])


def test_the_pooled_interval_covers_a_planted_ratio():
    rng = np.random.default_rng(6)
    covered = 0
    for _ in range(150):
        blocks = []
        for maps in (8, 10):
            task = rng.gamma(8, 1 / 8, maps).repeat(3) * rng.gamma(20, 2, 3 * maps)
            theirs = rng.gamma(20, 2, 3 * maps)
            blocks.append(block((task * theirs)[:, None], theirs[:, None], np.arange(maps).repeat(3)))
        _, low, high = paired_ratios(blocks, resamples=500)[0].of_tasks
        covered += low <= 40.0 <= high
    assert covered / 150 >= 0.9


def test_few_tasks_of_any_scenario_get_no_interval_and_steps_of_none_are_refused():
    (found,) = paired_ratios([block([[4.0], [6.0]], [[2.0], [2.0]]), drawn(9, columns=1)])
    assert found.of_tasks.low is None
    assert found.of_means.high is None
    for bad in ([], [block([[1.0]], [[0.0]])], [block(np.zeros((0, 1)), np.zeros((0, 1)))]):
        with pytest.raises(InputError, match="above 0"):
            paired_ratios(bad)
