"""Comparisons of policies with a baseline, tested as one family."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_explorers.env import InputError
from indoor_explorers.env.errors import did_you_mean
from indoor_explorers.evaluation.statistics.effects import effect_size, smallest_detectable_difference
from indoor_explorers.evaluation.statistics.equivalence import equivalence_test, units_to_resolve
from indoor_explorers.evaluation.statistics.estimate import CONFIDENCE, Estimate, Maps, paired_values
from indoor_explorers.evaluation.statistics.means import bootstrap_mean, bootstrap_means
from indoor_explorers.evaluation.statistics.pairs import all_pairs_test
from indoor_explorers.evaluation.statistics.resampling import MapGroups
from indoor_explorers.evaluation.statistics.significance import holm, sign_flip_test
from indoor_explorers.evaluation.statistics.successes import success_test
from indoor_explorers.evaluation.statistics.wins import WinTieLoss, win_scores, win_tie_loss


class Finding(StrEnum):
    """What a comparison shows about a policy against its baseline."""

    BETTER = "better"
    WORSE = "worse"
    MIXED = "mixed"
    """Better where both finished, but finished fewer tasks; or the other way round."""
    AS_GOOD = "as good"
    """Neither mean is the margin or more above the other."""
    OPEN = "not resolved"


@dataclass(frozen=True, kw_only=True)
class Contrast:
    """One policy against a baseline over the tasks that both flew.

    Means are compared over the tasks that both finished, and the numbers of tasks that each finished beside them. The
    adjusted p-values, for all comparisons with the baseline, decide what is significant. The interval, for this
    comparison alone, says how large the difference may be. They come from different resampling and can, rarely,
    disagree near the limit.
    """

    difference: Estimate
    """Mean of policy minus baseline over the tasks that both finished, with its interval."""
    improvement: Estimate
    """Probability that the policy does better on a task, ties one half, with its interval."""
    tally: WinTieLoss
    """Tasks on which the policy was better, equal and worse."""
    p_value: float
    """Two-sided p-value of the sign-flip test for this comparison alone."""
    adjusted_p: float
    """The same, adjusted by Holm's method over all comparisons with the baseline, or over all pairs of policies."""
    success_p: float
    """Two-sided p-value of the numbers of tasks finished, adjusted together with the others."""
    equivalence_p: float
    """p-value of "the means differ by the margin or more", adjusted for the family; NaN without a margin."""
    effect_size: float
    """Mean difference in standard deviations of the differences; NaN where they have no spread."""
    detectable: float
    """Smallest true difference found with 80 % power, at the level of Holm's first step or of the test of all pairs."""
    needed: float
    """Maps, or tasks, that would resolve it with 80 % power if it is as observed; NaN without a margin."""
    pairs: int
    """Tasks that both flew."""
    both: int
    """Those that both finished."""
    finished: tuple[int, int]
    """Tasks that the policy finished, and the baseline."""
    maps: int
    """Distinct maps among them; as many as pairs where maps were not given."""
    over_maps: bool
    """True: the interval holds for maps like these. False: for these maps alone, because they are too few."""
    margin: float
    """By which share a mean may exceed the other for the two to be as good; 0 for no such statement."""
    lower_is_better: bool
    """Whether a smaller value is an improvement."""

    @property
    def finding(self) -> Finding:
        """What is shown: the rule of :meth:`~indoor_explorers.evaluation.statistics.pairs.AllPairs.better`."""
        ahead = self.shown and (self.difference.mean < 0) == self.lower_is_better
        behind = self.shown and not ahead
        more = self.finished[0] - self.finished[1]
        if (ahead and more >= 0) or (self.success_shown and more > 0 and not behind):
            return Finding.BETTER
        if (behind and more <= 0) or (self.success_shown and more < 0 and not ahead):
            return Finding.WORSE
        if self.shown:
            return Finding.MIXED
        return Finding.AS_GOOD if self.equivalent else Finding.OPEN

    @property
    def equivalent(self) -> bool:
        """Whether neither mean is shown to be the margin above the other; a significant difference may be smaller."""
        return self.equivalence_p <= 1 - CONFIDENCE

    @property
    def success_shown(self) -> bool:
        """Whether one is shown to finish more tasks than the other."""
        return self.success_p <= 1 - CONFIDENCE

    @property
    def shown(self) -> bool:
        """Whether the difference of the means is significant, adjusted for the number of comparisons."""
        return self.adjusted_p <= 1 - CONFIDENCE


def contrasts(
    values: Mapping[str, ArrayLike],
    baseline: str,
    *,
    maps: Maps = None,
    lower_is_better: bool = True,
    chosen: bool = False,
    reached: Mapping[str, ArrayLike] | None = None,
    margin: float = 0.0,
) -> dict[str, Contrast]:
    """Compare every policy with the baseline; p-values are adjusted over all of them.

    Policies with the same values count as one, and those with the baseline's as none.

    Args:
        values: (E,) by policy, on the same tasks in the same order.
        baseline: the policy that the others are compared with.
        maps: (E,) label of the map each task was flown on.
        lower_is_better: whether a smaller value is an improvement.
        chosen: whether the baseline was chosen by these values, as the best is: all pairs are then tested at once.
        reached: (E,) by policy, whether it finished each task; by default all did.
        margin: by which share a mean may exceed the other for the two to be as good; 0 for no such test.

    Returns:
        A contrast for every policy but the baseline, in the order given.

    Raises:
        InputError: the baseline is unknown, there is no task, or the values are not pairs of finite numbers.

    """
    if baseline not in values:
        raise InputError(f"expected a baseline among the policies, got {baseline!r}{did_you_mean(baseline, values)}")
    others = [name for name in values if name != baseline]
    if not others:
        return {}
    flown = np.stack([paired_values(row, values[baseline])[0] for row in values.values()], axis=1)
    ended = np.stack([np.ones(len(flown)) if reached is None else reached[name] for name in values], axis=1) > 0
    family = _Family(flown, ended, list(values).index(baseline), maps, lower_is_better, margin)
    return dict(zip(others, family.contrasts(chosen), strict=True))


class _Tests(NamedTuple):
    """The adjusted p-values of the policies other than the baseline, and the level of a single test."""

    adjusted_p: NDArray[np.float64]
    success_p: NDArray[np.float64]
    level: float


@dataclass(frozen=True, eq=False)
class _Family:
    """The comparisons of K policies with the one of them that is the baseline."""

    flown: NDArray[np.float64]
    """(E, K) values."""
    ended: NDArray[np.bool_]
    """(E, K) whether the task was finished."""
    place: int
    """Column of the baseline."""
    maps: Maps
    lower_is_better: bool
    margin: float

    def contrasts(self, chosen: bool) -> list[Contrast]:
        columns = [column for column in range(self.flown.shape[1]) if column != self.place]
        p_values = [sign_flip_test(row, self.maps) for row in self._apart(columns).T]
        tests = self._all_pairs() if chosen else self._with_baseline(columns, p_values)
        equal = self._equivalence_p(columns, chosen)
        scores = [win_scores(*self._pair(k), lower_is_better=self.lower_is_better) for k in columns]
        whole = [ours - theirs for ours, theirs in map(self._pair, columns)]
        estimates = bootstrap_means(np.stack([*whole, *scores], axis=1), maps=self.maps)
        return [
            Contrast(
                improvement=estimates[len(columns) + k],
                p_value=p_values[k],
                adjusted_p=float(tests.adjusted_p[k]),
                success_p=float(tests.success_p[k]),
                equivalence_p=float(equal[k]),
                margin=self.margin,
                lower_is_better=self.lower_is_better,
                **self._counts(column),
                **self._effect(column, estimates[k], tests.level),
            )
            for k, column in enumerate(columns)
        ]

    def _pair(self, column: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        return self.flown[:, column], self.flown[:, self.place]

    def _both(self, column: int) -> NDArray[np.bool_]:
        return np.asarray(self.ended[:, column] & self.ended[:, self.place])

    def _apart(self, columns: Sequence[int]) -> NDArray[np.float64]:
        """Return (E, K - 1) differences, 0 where one of the two did not finish."""
        apart = self.flown[:, columns] - self.flown[:, [self.place]]
        return np.where(np.stack([self._both(column) for column in columns], axis=1), apart, 0.0)

    def _all_pairs(self) -> _Tests:
        found = all_pairs_test(self.flown, self.maps, self.ended)
        mean, success = (np.delete(p[self.place], self.place) for p in (found.adjusted_p, found.success_p))
        return _Tests(mean, success, found.level)

    def _with_baseline(self, columns: Sequence[int], p_values: Sequence[float]) -> _Tests:
        """Adjust means and successes by Holm's method; equal differences count once, and those of 0 not at all."""
        wins = self.ended[:, columns].astype(np.float64) - self.ended[:, [self.place]]
        both = [success_test(self.ended[:, k], self.ended[:, self.place], self.maps) for k in columns]
        rows = np.concatenate((self._apart(columns), wins), axis=1).T
        distinct, first, same = np.unique(rows, axis=0, return_index=True, return_inverse=True)
        tested = distinct.any(axis=1)
        adjusted = np.ones(len(distinct))
        adjusted[tested] = holm(np.array([*p_values, *both])[first[tested]])
        mean, success = np.split(adjusted[same.ravel()], 2)
        return _Tests(mean, success, (1 - CONFIDENCE) / max(1, int(tested.sum())))

    def _equivalence_p(self, columns: Sequence[int], chosen: bool) -> NDArray[np.float64]:
        if not self.margin:
            return np.full(len(columns), np.nan)
        pairs = list(combinations(range(self.flown.shape[1]), 2)) if chosen else [(k, self.place) for k in columns]
        p = equivalence_test(self.flown, pairs, self.margin, maps=self.maps, reached=self.ended)
        return p[[self.place in pair for pair in pairs]]

    def _counts(self, column: int) -> dict[str, Any]:
        layout = MapGroups.of(self.maps, len(self.flown))
        return {
            "tally": win_tie_loss(*self._pair(column), self.lower_is_better),
            "pairs": len(self.flown),
            "both": int(self._both(column).sum()),
            "finished": (int(self.ended[:, column].sum()), int(self.ended[:, self.place].sum())),
            "maps": len(layout.size),
            "over_maps": layout.sampled,
        }

    def _effect(self, column: int, whole: Estimate, level: float) -> dict[str, Any]:
        """Return how large the difference is over the tasks that both finished; ``whole`` is that over all tasks."""
        both = self._both(column)
        ours, theirs = (values[both] for values in self._pair(column))
        maps, apart = None if self.maps is None else np.asarray(self.maps)[both], ours - theirs
        needed = units_to_resolve(ours, theirs, self.margin, level=level, maps=maps) if self.margin else math.nan
        return {
            "difference": whole if both.all() else bootstrap_mean(apart, maps=maps),
            "effect_size": effect_size(apart),
            "detectable": smallest_detectable_difference(apart, level=level, maps=maps),
            "needed": needed,
        }
