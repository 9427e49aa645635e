"""How often one policy is better than another on the same task."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_explorers.evaluation.statistics.estimate import RESAMPLES, Estimate, Maps, paired_values
from indoor_explorers.evaluation.statistics.means import bootstrap_mean


class WinTieLoss(NamedTuple):
    """On how many tasks a policy was better than, equal to and worse than a baseline."""

    wins: int
    ties: int
    losses: int


def win_scores(values: ArrayLike, baseline: ArrayLike, *, lower_is_better: bool = True) -> NDArray[np.float64]:
    """Return (E,) scores of (E,) values: 1 where better than the baseline, 0.5 where equal, 0 where worse.

    Raises:
        InputError: the values are not pairs of finite numbers.

    """
    ours, theirs = paired_values(values, baseline)
    ahead = np.sign(theirs - ours) if lower_is_better else np.sign(ours - theirs)
    return np.asarray((1 + ahead) / 2)


def win_tie_loss(values: ArrayLike, baseline: ArrayLike, lower_is_better: bool = True) -> WinTieLoss:
    """Count the tasks on which (E,) values are better than, equal to and worse than the baseline.

    Raises:
        InputError: the values are not pairs of finite numbers.

    """
    scores = win_scores(values, baseline, lower_is_better=lower_is_better)
    return WinTieLoss(*(int((scores == score).sum()) for score in (1.0, 0.5, 0.0)))


def probability_of_improvement(
    values: ArrayLike,
    baseline: ArrayLike,
    *,
    lower_is_better: bool = True,
    maps: Maps = None,
    resamples: int = RESAMPLES,
) -> Estimate:
    """Return the probability that a policy does better than the baseline on a task, with its interval.

    Ties count one half. Agarwal et al. (2021, arXiv:2108.13264, section 4.3) compare all pairs of runs; here
    only the two episodes of the same task are compared. Where all pairs agree, the interval has no width.

    Raises:
        InputError: the values are not pairs of finite numbers.

    """
    scores = win_scores(values, baseline, lower_is_better=lower_is_better)
    return bootstrap_mean(scores, resamples=resamples, maps=maps)
