"""Bootstrap resamples of episodes; where maps are known, maps are drawn before episodes.

Episodes on the same map are alike, so that 10 maps with 30 seeds each say less about other maps than 300 maps
would. Three cases:

- no maps given, all episodes on one map, or each on its own: episodes are drawn with replacement;
- at least :data:`~indoor_explorers.evaluation.statistics.estimate.FEWEST` maps: the maps are a sample. Maps are
  drawn with replacement, and then episodes with replacement within each drawn map (the two-stage bootstrap of
  Davison & Hinkley 1997, Bootstrap Methods and their Application, section 3.8, doi:10.1017/CBO9780511802843);
- fewer maps: the maps are fixed, and episodes are drawn with replacement within each (a stratified bootstrap).

A resample is a row of weights that sum to 1: the resampled mean of (E,) values is ``weights @ values``. The
generators are seeded in each call, so that all policies get the same resamples.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special

from indoor_explorers.env import InputError
from indoor_explorers.env.grid.compiled import leaf
from indoor_explorers.evaluation.statistics.estimate import CONFIDENCE, FEWEST, Maps

#: Weights in memory at a time, and the fewest resamples; products with fewer rows are slow.
CHUNK, FEWEST_ROWS = 2**18, 32
#: Random numbers in memory at a time: what a processor keeps near.
AT_ONCE = 2**16


@dataclass(frozen=True, eq=False)
class MapGroups:
    """Which episode was flown on which map; maps are numbered by first appearance."""

    label: NDArray[np.int64]
    """(E,) map of each episode."""
    size: NDArray[np.int64]
    """(M,) episodes of each map."""
    order: NDArray[np.int64]
    """(E,) episodes, those of the first map first."""
    first: NDArray[np.int64]
    """(M,) place in ``order`` of each map's first episode."""
    sampled: bool
    """True: the maps are a sample of maps like them. False: they are too few and are taken as fixed."""

    @classmethod
    def of(cls, maps: Maps, count: int) -> MapGroups:
        """Group ``count`` episodes by their (E,) ``maps``; without maps, each episode has its own.

        Raises:
            InputError: there is not one label for each episode.

        """
        labels = np.arange(count) if maps is None else np.asarray(maps)
        if labels.shape != (count,):
            raise InputError(
                f"expected the maps of {count} episodes, got labels of shape {labels.shape}; pass one an episode"
            )
        _, first, inverse = np.unique(labels, return_index=True, return_inverse=True)
        label = np.argsort(np.argsort(first))[inverse]
        size = np.bincount(label)
        sampled = maps is None or len(size) >= FEWEST
        return cls(label, size, np.argsort(label, kind="stable"), np.cumsum(size) - size, sampled)

    def within(self, draws: NDArray[np.int64], rng: np.random.Generator) -> NDArray[np.float64]:
        """Draw ``draws[r, m]`` episodes of map m with replacement; return which share each is of its row, (R, E)."""
        shares = np.empty((len(draws), len(self.label)))
        counts = np.zeros(len(self.label), np.uint32)
        rows = max(1, AT_ONCE // len(self.label))
        for start in range(0, len(draws), rows):
            here = draws[start : start + rows]
            uniform = rng.random(int(here.sum()))
            _draw(here, uniform, self.order, self.first, self.size, counts, shares[start : start + rows])
        return shares


def maps_are_sampled(maps: Maps) -> bool:
    """Return whether intervals hold for maps like these; False: only for these maps, which are too few.

    Without maps, every episode counts as a map of its own.
    """
    return maps is None or MapGroups.of(maps, np.size(maps)).sampled


def resampled_weights(count: int, resamples: int, maps: Maps = None) -> Iterator[NDArray[np.float64]]:
    """Yield bootstrap weights of ``count`` episodes in chunks (r, E), ``resamples`` rows in all.

    Args:
        count: episodes E.
        resamples: rows in all.
        maps: (E,) label of the map each episode was flown on.

    Raises:
        InputError: there is not one label an episode.

    """
    layout = MapGroups.of(maps, count)
    if len(layout.size) == 1:
        layout = MapGroups.of(None, count)
    draw = _Sampled(layout) if layout.sampled else _Fixed(layout)
    rows = max(FEWEST_ROWS, CHUNK // max(1, count))
    for start in range(0, resamples, rows):
        yield draw(min(rows, resamples - start))


def independent_units(differences: NDArray[np.float64], maps: Maps) -> NDArray[np.float64]:
    """Return the independent units of (E,) or (E, K) differences, whose mean is that over all episodes.

    They are the sums over each map, divided by the mean number of episodes a map, where maps are a sample; else the
    episodes.
    """
    layout = MapGroups.of(maps, len(differences))
    if not layout.sampled or not len(differences):
        return differences
    sums = np.add.reduceat(differences[layout.order], layout.first, axis=0)
    return np.asarray(sums / (len(differences) / len(layout.size)))


class _Sampled:
    """Draw maps, then episodes within them; episodes alone where each has its own map."""

    def __init__(self, layout: MapGroups) -> None:
        self.layout = layout
        self.maps, self.episodes = np.random.default_rng(0), np.random.default_rng((0, 1))

    def __call__(self, rows: int) -> NDArray[np.float64]:
        layout, maps = self.layout, len(self.layout.size)
        times = _counted(np.arange(rows)[:, None], self.maps.integers(0, maps, (rows, maps)), (rows, maps))
        if maps == len(layout.label):
            return times / maps
        return layout.within(times * layout.size, self.episodes)


class _Fixed:
    """Draw episodes within each map, as many as it has."""

    def __init__(self, layout: MapGroups) -> None:
        self.layout = layout
        self.episodes = np.random.default_rng(0)

    def __call__(self, rows: int) -> NDArray[np.float64]:
        return self.layout.within(np.tile(self.layout.size, (rows, 1)), self.episodes)


@leaf()
def _draw(
    draws: NDArray[np.int64],
    uniform: NDArray[np.float64],
    order: NDArray[np.int64],
    first: NDArray[np.int64],
    size: NDArray[np.int64],
    counts: NDArray[np.uint32],
    shares: NDArray[np.float64],
) -> None:
    """Fill (R, E) ``shares`` of the episodes that numbers from 0 to 1 choose within maps, ``draws[r, m]`` of map m.

    ``counts`` is (E,) memory to work with, in the order of the maps: small numbers in a row are quicker to add to.
    """
    used = 0
    for row in range(draws.shape[0]):
        counts[:] = 0
        before = used
        for drawn in range(draws.shape[1]):
            for _ in range(draws[row, drawn]):
                counts[first[drawn] + int(uniform[used] * size[drawn])] += 1
                used += 1
        for place in range(len(order)):
            shares[row, order[place]] = counts[place] / (used - before)


def _counted(row: NDArray[np.int64], column: NDArray[np.int64], shape: tuple[int, int]) -> NDArray[np.int64]:
    """Return how often each (row, column) occurs."""
    return np.bincount((row * shape[1] + column).ravel(), minlength=shape[0] * shape[1]).reshape(shape)


@dataclass(frozen=True)
class SmallSample:
    """Number of units and degrees of freedom of a sample, by which intervals and bands of few units are widened.

    A percentile bootstrap interval over few units n is too narrow: the variance of its resamples is too small by
    (n - 1) / n, and their distribution is not Student's. The expanded percentile interval takes more extreme quantiles
    of the same resamples, so that the mean of normal values gets the width of its t interval (Hesterberg 2015, The
    American Statistician 69:371, doi:10.1080/00031305.2015.1089789). From about 100 units on the difference is
    negligible. Quantiles are those of ``scipy.special``: ``scipy.stats`` takes half a second to import.
    """

    units: int
    """Units that are drawn: maps where these are a sample, else episodes."""
    freedom: int
    """Degrees of freedom: units minus the groups that they are drawn within."""

    @classmethod
    def of(cls, count: int, maps: Maps) -> SmallSample:
        """Return units and freedom of ``count`` episodes on (E,) ``maps``."""
        layout = MapGroups.of(maps, count)
        if layout.sampled:
            return cls(len(layout.size), len(layout.size) - 1)
        return cls(count, count - len(layout.size))

    @property
    def tails(self) -> tuple[float, float]:
        """The two quantiles of the resamples that bound a 95 % interval."""
        reach = self.widened(float(special.ndtri((1 + CONFIDENCE) / 2)))
        return float(special.ndtr(-reach)), float(special.ndtr(reach))

    def widened(self, multiplier: float) -> float:
        """Return how many standard deviations of the resamples correspond to ``multiplier`` for many units."""
        return math.sqrt(self.units / self.freedom) * float(-special.stdtrit(self.freedom, special.ndtr(-multiplier)))
