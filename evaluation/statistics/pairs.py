"""The test of all pairs of policies, and ranks with ties; some episodes may never reach the threshold."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.evaluation.statistics.estimate import CONFIDENCE, Maps, episode_values
from indoor_explorers.evaluation.statistics.resampling import independent_units
from indoor_explorers.evaluation.statistics.significance import max_t_test


class AllPairs(NamedTuple):
    """The test of all pairs of K policies; row minus column."""

    adjusted_p: NDArray[np.float64]
    """(K, K) of the mean differences, symmetric; 1 on the diagonal."""
    level: float
    """The level at which a t test of one pair alone would be as strict."""
    difference: NDArray[np.float64]
    """(K, K) mean differences over the tasks that both finished; 0 where there are none."""
    success_p: NDArray[np.float64]
    """(K, K) of the shares of tasks that were finished, adjusted together with those of the means."""
    success: NDArray[np.float64]
    """(K, K) differences of these shares."""

    def better(self, *, lower_is_better: bool = True) -> NDArray[np.bool_]:
        """Return (K, K) whether the policy of the row is significantly better than that of the column.

        It is if its mean over the tasks that both finished is significantly better and it did not finish fewer tasks,
        or if it finished significantly more and is not significantly worse where both finished.
        """
        gain = -self.difference if lower_is_better else self.difference
        ahead = (self.adjusted_p <= 1 - CONFIDENCE) & (gain > 0)
        surer = (self.success_p <= 1 - CONFIDENCE) & (self.success > 0)
        return np.asarray((ahead & (self.success >= 0)) | (surer & ~ahead.T))


def all_pairs_test(
    values: NDArray[np.float64], maps: Maps = None, reached: NDArray[np.bool_] | None = None
) -> AllPairs:
    """Test all pairs of K policies at once, so that any of them may be chosen afterwards.

    Two families of statistics are tested together, see
    :func:`~indoor_explorers.evaluation.statistics.significance.max_t_test`: the mean differences over the tasks that
    both policies finished, and the differences of the numbers of tasks that they finished. Where all finished all, only
    the first are left. Policies with the same values count as one.

    Args:
        values: (E, K) on the same tasks.
        maps: (E,) label of the map each task was flown on.
        reached: (E, K) whether each task was finished; by default all.

    """
    flown = np.stack([episode_values(column) for column in values.T], axis=1)
    ended = np.ones(flown.shape, np.bool_) if reached is None else reached
    one, other = np.triu_indices(flown.shape[1], 1)
    both = ended[:, one] & ended[:, other]
    apart = np.where(both, flown[:, one] - flown[:, other], 0.0)
    wins = ended[:, one].astype(np.float64) - ended[:, other]
    found = max_t_test(independent_units(np.concatenate((apart, wins), axis=1), maps))
    p_values = np.split(found.adjusted_p, 2)
    means = apart.sum(axis=0) / np.maximum(both.sum(axis=0), 1)
    return AllPairs(
        adjusted_p=1.0 + _square(p_values[0] - 1.0, flown.shape[1], 1),
        level=found.level,
        difference=_square(means, flown.shape[1], -1),
        success_p=1.0 + _square(p_values[1] - 1.0, flown.shape[1], 1),
        success=_square(wins.mean(axis=0), flown.shape[1], -1),
    )


def _square(pairs: NDArray[np.float64], count: int, sign: int) -> NDArray[np.float64]:
    """Return a (K, K) matrix of the values of all pairs, with ``sign`` for the pairs in the other order."""
    square = np.zeros((count, count))
    square[np.triu_indices(count, 1)] = pairs
    return square + sign * square.T


def tied_ranks(
    values: NDArray[np.float64],
    maps: Maps = None,
    *,
    reached: NDArray[np.bool_] | None = None,
    lower_is_better: bool = True,
) -> list[int]:
    """Return the rank of each of K policies: 1 + the number of policies that are significantly better.

    All pairs are tested at once, see :class:`~indoor_explorers.evaluation.statistics.pairs.AllPairs`. Policies between
    which no difference is shown may still have different ranks, when a third one is shown to be better than one of them
    alone.

    Args:
        values: (E, K) on the same tasks.
        maps: (E,) label of the map each task was flown on.
        reached: (E, K) whether each task was finished; by default all.
        lower_is_better: whether a smaller value is better.

    """
    if values.shape[1] < 2:
        return [1] * values.shape[1]
    better = all_pairs_test(values, maps, reached).better(lower_is_better=lower_is_better)
    return [1 + int(count) for count in better.sum(axis=0)]
