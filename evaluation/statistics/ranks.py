"""Ranks of policies, with ties where no difference is shown."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_explorers.evaluation.statistics.estimate import CONFIDENCE
from indoor_explorers.evaluation.statistics.significance import all_pairs_test


def tied_ranks(
    values: NDArray[np.float64], maps: ArrayLike | None = None, *, lower_is_better: bool = True
) -> list[int]:
    """Return the rank of each of K policies: 1 + the number of policies that are significantly better.

    All pairs are tested at once, see :func:`all_pairs_test`. Policies between which no difference is shown may still
    have different ranks, when a third one is shown to be better than one of them alone.

    Args:
        values: (E, K) on the same tasks.
        maps: (E,) label of the map each task was flown on.
        lower_is_better: whether a smaller value is better.

    """
    means = values.mean(axis=0) * (1 if lower_is_better else -1)
    if len(means) < 2:
        return [1] * len(means)
    shown = all_pairs_test(values, maps).adjusted_p <= 1 - CONFIDENCE
    better = shown & (means[None, :] < means[:, None])
    return [1 + int(count) for count in better.sum(axis=1)]
