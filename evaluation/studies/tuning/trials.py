"""The trials of a study as tables and figures show them, and the importance of the parameters by PED-ANOVA."""

from __future__ import annotations

import warnings
from typing import Any, NamedTuple

import numpy as np
import optuna
from optuna.trial import TrialState

from indoor_explorers.evaluation.studies.tuning.plan import Search
from indoor_explorers.evaluation.studies.tuning.search import finished
from indoor_explorers.evaluation.studies.tuning.sequential import VALUES

#: Fewer trials, or fewer different values of them, say nothing about importance.
FEWEST, DIFFERENT = 10, 4


class Flown(NamedTuple):
    """A trial."""

    number: int
    """0 for the default parameters."""
    value: float
    """Relative to the default's; of a dropped one the estimate from its paired difference to the best."""
    episodes: int
    dropped: bool
    best: float
    """The best value of the trials so far that were flown to the end."""
    parameters: dict[str, Any]
    """As flown."""


def flown_trials(search: Search, study: optuna.Study) -> list[Flown]:
    """Return the trials in order."""
    best, sign, found = np.inf, 1.0 if search.measure.lower_is_better else -1.0, []
    for number, trial in enumerate(finished(study)):
        dropped = trial.state is TrialState.PRUNED
        value = trial.intermediate_values[trial.last_step or 0] if dropped else trial.value
        assert value is not None
        best = best if dropped else min(best, sign * value)
        drawn = search.space.with_parameters("", trial.params).parameters
        given = {name: drawn[name] for name in search.space.ranges}
        found.append(Flown(number, value, len(trial.user_attrs[VALUES]), dropped, sign * best, given))
    return found


def importances(search: Search, study: optuna.Study) -> dict[str, float]:
    """Return the share of each parameter in what makes a trial good, the largest first; empty for too few trials.

    By PED-ANOVA (Watanabe, Bansal & Hutter 2023, IJCAI, doi:10.24963/ijcai.2023/488), which needs no further library.
    Dropped trials count with their estimates.
    """
    flown = flown_trials(search, study)
    if len(flown) < FEWEST or len({each.value for each in flown}) < DIFFERENT or len(search.space.ranges) < 2:
        return {}
    whole = optuna.create_study(direction=study.direction)
    for trial, each in zip(finished(study), flown, strict=True):
        whole.add_trial(
            optuna.trial.create_trial(params=trial.params, distributions=trial.distributions, value=each.value)
        )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        evaluator = optuna.importance.PedAnovaImportanceEvaluator()
        return dict(optuna.importance.get_param_importances(whole, evaluator=evaluator))
