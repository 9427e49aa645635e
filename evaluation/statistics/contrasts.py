"""Comparisons of policies with a baseline, tested as one family."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_explorers.env import InputError
from indoor_explorers.env.errors import did_you_mean
from indoor_explorers.evaluation.statistics.effects import effect_size, smallest_detectable_difference
from indoor_explorers.evaluation.statistics.estimate import CONFIDENCE, Estimate, paired_values
from indoor_explorers.evaluation.statistics.means import bootstrap_means
from indoor_explorers.evaluation.statistics.resampling import MapGroups
from indoor_explorers.evaluation.statistics.significance import all_pairs_test, holm, sign_flip_test
from indoor_explorers.evaluation.statistics.wins import WinTieLoss, win_scores, win_tie_loss


@dataclass(frozen=True, kw_only=True)
class Contrast:
    """One policy against a baseline over the tasks that both flew.

    The adjusted p-value, for all comparisons with the baseline, decides whether a difference is significant. The
    interval, for this comparison alone, says how large the difference may be. They come from different resampling
    and can, rarely, disagree near the limit.
    """

    difference: Estimate
    """Mean of policy minus baseline, with its interval."""
    improvement: Estimate
    """Probability that the policy does better on a task, ties one half, with its interval."""
    tally: WinTieLoss
    """Tasks on which the policy was better, equal and worse."""
    p_value: float
    """Two-sided p-value of the sign-flip test for this comparison alone."""
    adjusted_p: float
    """The same, adjusted by Holm's method over all comparisons with the baseline, or over all pairs of policies."""
    effect_size: float
    """Mean difference in standard deviations of the differences; NaN where they have no spread."""
    detectable: float
    """Smallest true difference found with 80 % power, at the level of Holm's first step or of the test of all pairs."""
    pairs: int
    """Tasks that both flew."""
    maps: int
    """Distinct maps among them; as many as pairs where maps were not given."""
    over_maps: bool
    """True: the interval holds for maps like these. False: for these maps alone, because they are too few."""

    @property
    def shown(self) -> bool:
        """Whether the difference is significant, adjusted for the number of comparisons."""
        return self.adjusted_p <= 1 - CONFIDENCE


def contrasts(
    values: Mapping[str, ArrayLike],
    baseline: str,
    *,
    maps: ArrayLike | None = None,
    lower_is_better: bool = True,
    chosen: bool = False,
) -> dict[str, Contrast]:
    """Compare every policy with the baseline; p-values are adjusted over all of them.

    Policies with the same values count as one, and those with the baseline's as none.

    Args:
        values: (E,) by policy, on the same tasks in the same order.
        baseline: the policy that the others are compared with.
        maps: (E,) label of the map each task was flown on.
        lower_is_better: whether a smaller value is an improvement.
        chosen: whether the baseline was chosen by these values, as the best is: all pairs are then tested at once.

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
    pairs = [paired_values(values[name], values[baseline]) for name in others]
    differences = np.stack([ours - theirs for ours, theirs in pairs])
    scores = np.stack([win_scores(*pair, lower_is_better=lower_is_better) for pair in pairs])
    estimates = bootstrap_means(np.concatenate((differences, scores)).T, maps=maps)
    p_values = [sign_flip_test(row, maps) for row in differences]
    layout = MapGroups.of(maps, differences.shape[1])
    adjusted_p, level = _adjusted(values, baseline, differences, p_values, maps, chosen)
    return {
        name: Contrast(
            difference=estimates[k],
            improvement=estimates[len(others) + k],
            tally=win_tie_loss(*pairs[k], lower_is_better),
            p_value=p_values[k],
            adjusted_p=adjusted,
            effect_size=effect_size(differences[k]),
            detectable=smallest_detectable_difference(differences[k], level=level, maps=maps),
            pairs=len(layout.label),
            maps=len(layout.size),
            over_maps=layout.sampled,
        )
        for k, (name, adjusted) in enumerate(zip(others, adjusted_p, strict=True))
    }


def _adjusted(
    values: Mapping[str, ArrayLike],
    baseline: str,
    differences: NDArray[np.float64],
    p_values: Sequence[float],
    maps: ArrayLike | None,
    chosen: bool,
) -> tuple[list[float], float]:
    """Return the adjusted p-values, and the level of a single test of the family."""
    if chosen and len(values) > 2:
        found = all_pairs_test(np.stack([np.asarray(each, np.float64) for each in values.values()], axis=1), maps)
        place = list(values).index(baseline)
        return np.delete(found.adjusted_p[place], place).tolist(), found.level
    distinct, first, same = np.unique(differences, axis=0, return_index=True, return_inverse=True)
    tested = distinct.any(axis=1)
    adjusted = np.ones(len(distinct))
    adjusted[tested] = holm(np.asarray(p_values)[first[tested]])
    return adjusted[same.ravel()].tolist(), (1 - CONFIDENCE) / max(1, int(tested.sum()))
