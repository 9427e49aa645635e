"""Ranks of policies, with ties where no difference is shown."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_explorers.evaluation.statistics.pairs import all_pairs_test


def tied_ranks(
    values: NDArray[np.float64],
    maps: ArrayLike | None = None,
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
