"""Shares of episodes that reached a threshold: exact intervals, and a paired test of two policies."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from indoor_explorers.evaluation.statistics.estimate import CONFIDENCE, FEWEST, Estimate, Maps, paired_values
from indoor_explorers.evaluation.statistics.resampling import independent_units
from indoor_explorers.evaluation.statistics.significance import sign_flip_test


def success_share(reached: ArrayLike) -> Estimate:
    """Return the share of (E,) episodes that reached a threshold with its exact 95 % interval.

    The interval is that of Clopper & Pearson (1934, doi:10.1093/biomet/26.4.404), which ``scipy.stats.binomtest`` has
    too. It takes episodes as independent; with fewer than five of them there is none.
    """
    flags = np.asarray(reached, np.bool_)
    count, hits = len(flags), int(flags.sum())
    if count < FEWEST:
        return Estimate(hits / count if count else float("nan"), None, None)
    tail = (1 - CONFIDENCE) / 2
    low = float(special.betaincinv(hits, count - hits + 1, tail)) if hits else 0.0
    high = float(special.betaincinv(hits + 1, count - hits, 1 - tail)) if hits < count else 1.0
    return Estimate(hits / count, low, high)


def success_test(reached: ArrayLike, baseline: ArrayLike, maps: Maps = None) -> float:
    """Return the two-sided p-value of a paired test of success: McNemar's, exact.

    Of the tasks that just one of the two solved, either is as likely to have solved each if they succeed equally often
    (McNemar 1947, doi:10.1007/BF02295996). Where several episodes share one of at least five maps, the numbers of the
    maps are tested by :func:`sign_flip_test`, which is the same test for one episode a map.

    Args:
        reached: (E,) whether the policy reached the threshold.
        baseline: (E,) the same of the other policy on the same tasks.
        maps: (E,) label of the map each was flown on.

    """
    ours, theirs = paired_values(reached, baseline)
    units = independent_units(ours - theirs, maps)
    if not np.isin(units, (-1.0, 0.0, 1.0)).all():
        return sign_flip_test(ours - theirs, maps)
    more, less = int((units > 0).sum()), int((units < 0).sum())
    return min(1.0, 2 * float(special.bdtr(min(more, less), more + less, 0.5))) if more + less else 1.0


def undetected_share(failed: int, count: int) -> float:
    """Return the largest share of failures that ``failed`` of ``count`` episodes leave possible, with 95 % confidence.

    It is the one-sided limit of Clopper & Pearson, about 3 / count where none failed.
    """
    return float(special.betaincinv(failed + 1, count - failed, CONFIDENCE)) if failed < count else 1.0
