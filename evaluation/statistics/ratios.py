"""Ratios of one policy's values to another's, as ratio of means and mean of ratios, for one or more scenarios."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.statistics.estimate import FEWEST, RESAMPLES, Estimate, Maps, paired_values
from indoor_explorers.evaluation.statistics.resampling import SmallSample, resampled_weights


class PairedRatio(NamedTuple):
    """Ratios of a policy's values to a baseline's on the same tasks."""

    of_tasks: Estimate
    """Mean over tasks of the ratio: every task counts the same."""
    of_means: Estimate
    """Ratio of the means: long tasks count more."""


@dataclass(frozen=True, eq=False)
class Block:
    """K comparisons on the same E tasks of one scenario."""

    above: NDArray[np.float64]
    """(E, K) values of the policies."""
    below: NDArray[np.float64]
    """(E, K) values of their baselines, all above 0."""
    maps: NDArray[np.str_]
    """(E,) label of the map each task was flown on."""

    @property
    def columns(self) -> NDArray[np.float64]:
        """(E, 3 K) ratios, values and baselines."""
        return np.concatenate((self.above / self.below, self.above, self.below), axis=1)


def paired_ratios(blocks: Sequence[Block], *, resamples: int = RESAMPLES) -> list[PairedRatio]:
    """Return the K comparisons over all ``blocks`` together, each block with the same weight.

    The mean of ratios is the mean over the blocks of their means; the ratio of means is the ratio of the means over
    the blocks. Within a block tasks are drawn as in :mod:`~indoor_explorers.evaluation.statistics.resampling`, both
    values of a task together; the blocks themselves are fixed. Blocks of equal layout get equal draws, so that tasks
    with the same seed, which may share a map, are drawn together. The interval is widened for the block with the
    fewest units.

    Raises:
        InputError: there is no block or task, or a baseline's value is not above 0.

    """
    if not blocks or not all(len(each.below) and (each.below > 0).all() for each in blocks):
        raise InputError("expected blocks of tasks with baselines above 0, got none or others; count steps from 1")
    points = _both(np.mean([each.columns.mean(axis=0) for each in blocks], axis=0)[None])[:, 0]
    if min(len(each.below) for each in blocks) < FEWEST:
        return [PairedRatio(*(Estimate(point, None, None) for point in pair)) for pair in points.T.tolist()]
    drawn = _both(np.mean([_resampled(each, resamples) for each in blocks], axis=0))
    tails = min(SmallSample.of(len(each.below), each.maps).tails for each in blocks)
    figures = np.stack((points, *np.quantile(drawn, tails, axis=1)), axis=-1)
    return [PairedRatio(*(Estimate(*three) for three in pair)) for pair in figures.transpose(1, 0, 2).tolist()]


def ratio_of_means(
    numerator: ArrayLike, denominator: ArrayLike, *, maps: Maps = None, resamples: int = RESAMPLES
) -> Estimate:
    """Return mean(numerator) / mean(denominator) of (E,) values on the same tasks, with its interval.

    A resample takes both values of a task or none, so that what they have in common cancels. The mean of ratios would
    be dominated by a few quick episodes in the denominator (Davison & Hinkley 1997,
    Bootstrap Methods and their Application, example 1.2).

    Raises:
        InputError: the values are not pairs of finite numbers, there are none, or a denominator is not above 0.

    """
    above, below = paired_values(numerator, denominator)
    if not len(below) or (below <= 0).any():
        raise InputError("expected denominators above 0, got none or others; leave out what took no step")
    point = float(above.mean() / below.mean())
    if len(above) < FEWEST:
        return Estimate(point, None, None)
    drawn = [(weights @ above) / (weights @ below) for weights in resampled_weights(len(above), resamples, maps)]
    low, high = np.quantile(np.concatenate(drawn), SmallSample.of(len(above), maps).tails)
    return Estimate(point, float(low), float(high))


def _resampled(block: Block, resamples: int) -> NDArray[np.float64]:
    """Return (R, 3 K) resampled means of the block's columns."""
    means = block.columns.mean(axis=0)
    apart = block.columns - means  # equal values then give an interval without width
    weights = resampled_weights(len(apart), resamples, block.maps)
    return np.concatenate([means + each @ apart for each in weights])


def _both(means: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (2, R, K) means of ratios and ratios of means from (R, 3 K) means."""
    of_tasks, above, below = np.split(means, 3, axis=1)
    return np.stack((of_tasks, above / below))
