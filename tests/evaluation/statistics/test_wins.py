"""Who did better on the same task."""

import numpy as np
import pytest

from indoor_explorers.evaluation.statistics import bootstrap_mean, probability_of_improvement, win_tie_loss


def test_wins_ties_and_losses_by_hand():
    assert win_tie_loss([1, 2, 3, 9], [2, 2, 1, 3], lower_is_better=True) == (1, 1, 2)
    assert win_tie_loss([1, 2, 3, 9], [2, 2, 1, 3], lower_is_better=False) == (2, 1, 1)
    assert win_tie_loss([], []) == (0, 0, 0)


def test_ties_count_one_half():
    assert probability_of_improvement([1, 2, 3, 9], [2, 2, 1, 3]) == (0.375, None, None)
    assert probability_of_improvement(np.ones(9), np.ones(9)) == (0.5, 0.5, 0.5)


def test_it_is_about_pairs():
    difficulty = np.arange(30) * 100.0
    assert probability_of_improvement(difficulty - 1, difficulty) == (1, 1, 1)


def test_both_sides_add_to_one():
    one, other = np.random.default_rng(1).integers(0, 5, (2, 25)).astype(float)
    there, back = probability_of_improvement(one, other), probability_of_improvement(other, one)
    assert there.mean + back.mean == pytest.approx(1)
    assert probability_of_improvement(one, other, lower_is_better=False) == back
    assert there == bootstrap_mean((1 + np.sign(other - one)) / 2)
