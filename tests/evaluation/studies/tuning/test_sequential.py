"""The sequential test: its error rate, what it drops, and how Optuna asks it."""

import numpy as np
import optuna
import pytest
from optuna.trial import TrialState

from indoor_explorers.evaluation.studies.tuning.sequential import LEVEL, VALUES, PairedTest, is_worse, looks

OWN = [str(k) for k in range(64)]


def dropped_after(apart):
    """The look at which a trial with these differences is dropped, 0 if it is not."""
    every = looks(len(apart))
    return next((n for n in every if is_worse(apart[:n], OWN[:n], LEVEL / len(every))), 0)


@pytest.mark.parametrize(("episodes", "expected"), [(4, []), (8, []), (9, [8]), (32, [8, 16]), (65, [8, 16, 32, 64])])
def test_looks_double_and_the_last_episodes_need_none(episodes, expected):
    assert looks(episodes) == expected


@pytest.mark.parametrize("draw", ["normal", "laplace"])
def test_a_trial_as_good_as_the_best_is_dropped_with_the_stated_probability(draw):
    rng = np.random.default_rng(5)
    repeats = 600
    dropped = sum(dropped_after(getattr(rng, draw)(size=32)) > 0 for _ in range(repeats))
    assert dropped / repeats <= LEVEL + 3 * np.sqrt(LEVEL * (1 - LEVEL) / repeats)
    assert dropped > 0  # it is not merely never dropped


def test_what_the_test_does_not_assume_makes_it_wrong_less_often_than_the_guide_says():
    rng = np.random.default_rng(7)
    rarely_better = [dropped_after(1 - rng.exponential(size=32)) > 0 for _ in range(300)]
    assert LEVEL < np.mean(rarely_better) < 0.2
    dropped = []
    for _ in range(10):
        best = rng.normal(size=32)
        for flown in rng.normal(size=(40, 32)):
            dropped.append(dropped_after(flown - best) > 0)
            best = flown if not dropped[-1] and flown.mean() < best.mean() else best
    assert LEVEL < np.mean(dropped) < 0.2


def test_clearly_worse_trials_are_dropped_at_the_first_look_and_better_ones_never():
    rng = np.random.default_rng(6)
    apart = rng.normal(size=(60, 32))
    assert np.mean([dropped_after(each + 2) == 8 for each in apart]) > 0.95
    assert not any(dropped_after(each - 2) for each in apart)


def test_episodes_on_one_map_count_as_one():
    apart = np.repeat([3.0, -1.0, 2.0, 1.0, 2.5], 8)
    maps = np.repeat([*"abcde"], 8)
    assert is_worse(apart, OWN[:40], 0.025)
    assert not is_worse(apart, list(maps), 0.025)


@pytest.mark.parametrize(("direction", "sign"), [("minimize", 1.0), ("maximize", -1.0)])
def test_optuna_drops_by_it_in_both_directions(direction, sign):
    study = optuna.create_study(direction=direction, pruner=PairedTest(OWN[:32]))
    best = np.linspace(0.9, 1.1, 32)
    study.add_trial(optuna.trial.create_trial(value=1.0, user_attrs={VALUES: best.tolist()}))
    fates = []
    for shift in (0.3, -0.3):
        trial = study.ask()
        trial.set_user_attr(VALUES, (best[:8] + sign * shift).tolist())
        trial.report(1.0, 8)
        fates.append(trial.should_prune())
        study.tell(trial, state=TrialState.FAIL)
    assert fates == [True, False]
