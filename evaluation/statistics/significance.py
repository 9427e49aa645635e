"""Sign-flip tests of paired differences: of one mean, of several at once, and Holm's adjustment."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.statistics.estimate import CONFIDENCE, Maps, episode_values
from indoor_explorers.evaluation.statistics.resampling import independent_units

#: The test is exact, over all 2^units flips, up to this many units.
EXACT_UNITS = 14
#: Number of random flips for more units.
FLIPS = 10_000
#: Signs in memory at a time.
CHUNK = 2**20


def sign_flip_test(differences: ArrayLike, maps: Maps = None) -> float:
    """Return the two-sided p-value of the sign-flip test of paired differences (Fisher 1935).

    If neither policy were better, each difference would be as likely with the other sign. The p-value is the
    share of sign flips whose mean is at least as far from 0 as the observed one. What is flipped are the sums over
    the maps where ``maps`` are a sample (``maps_are_sampled``), and single episodes otherwise, so that the mean is
    that over all episodes however many a map has (flips of clusters; Cameron, Gelbach & Miller 2008,
    doi:10.1162/rest.90.3.414; Canay, Romano & Shaikh 2017, doi:10.3982/ECTA13081). Up to 14 units the test is exact,
    over all flips. Beyond, 10,000 seeded random flips are tried and the observed one is counted with them, so that p is
    never 0 (Phipson & Smyth 2010, doi:10.2202/1544-6115.1585). With n units p is at least 2 / 2^n, so 5 units never get
    below 0.0625.

    The exact p-values are those of ``scipy.stats.permutation_test``, which builds every flipped sample where
    this takes sums.

    Args:
        differences: (E,) policy minus baseline on the same tasks.
        maps: (E,) label of the map each was flown on.

    Raises:
        InputError: there is no pair, or not one finite difference and label for each episode.

    """
    sample = episode_values(differences)
    if not len(sample):
        raise InputError("expected at least one paired difference, got none; let both policies fly the same tasks")
    units = independent_units(sample, maps)
    total = units.sum()
    reached = abs(total) - 1e-12 * np.abs(units).sum()  # sums of the same numbers differ by their rounding
    beyond = sum(int((np.abs(total - 2 * (flipped @ units)) >= reached).sum()) for flipped in _flips(len(units)))
    return beyond / 2 ** len(units) if len(units) <= EXACT_UNITS else (beyond + 1) / (FLIPS + 1)


class MaxT(NamedTuple):
    """The test of several means at once."""

    adjusted_p: NDArray[np.float64]
    """(C,) two-sided p-values."""
    level: float
    """The level at which a t test of one of them alone would be as strict."""


def max_t_test(units: NDArray[np.float64]) -> MaxT:
    """Test whether the means of (U, C) independent units are 0, all at once.

    The statistic of a mean is the sum of its units over the root of their sum of squares, a monotone function of
    Student's t. A flip changes the signs of all C differences of a unit together, and an adjusted p-value is the share
    of flips in which the largest statistic of all reaches the own one (single-step max-T; Westfall & Young 1993,
    Resampling-Based Multiple Testing, chapter 2). Of one mean it is :func:`sign_flip_test`.
    """
    adjusted, live = np.ones(units.shape[1]), units.any(axis=0)
    if not live.any():
        return MaxT(adjusted, 1 - CONFIDENCE)
    apart = units[:, live] / np.sqrt((units[:, live] ** 2).sum(axis=0))
    total, count = apart.sum(axis=0), len(units)
    largest = np.sort(np.concatenate([np.abs(total - 2 * (f @ apart)).max(axis=1) for f in _flips(count)]))
    beyond = len(largest) - np.searchsorted(largest, np.abs(total) - 1e-9)
    sampled = count > EXACT_UNITS
    adjusted[live] = (beyond + sampled) / (len(largest) + sampled)
    alone = live.sum() == 1
    return MaxT(adjusted, 1 - CONFIDENCE if alone else _level_of(float(np.quantile(largest, CONFIDENCE)), count))


def _level_of(critical: float, count: int) -> float:
    """Return the two-sided level of a t test with this critical value of the statistic, where the test can reach it."""
    left = count - critical**2
    reached = -critical * np.sqrt((count - 1) / left) if left > 0 else -np.inf
    return min(1 - CONFIDENCE, max(2 * float(special.stdtr(count - 1, reached)), 2.0 ** (1 - count)))


def holm(p_values: ArrayLike) -> NDArray[np.float64]:
    """Return p-values adjusted for the number of comparisons, in the order given (Holm 1979, jstor.org/stable/4615733).

    If differences with an adjusted value of at most 0.05 are called significant, the probability of any false
    positive is at most 0.05, however the comparisons depend on each other. The k-th smallest of m p-values is
    multiplied by m - k + 1; no value is below one of a smaller p-value, and none above 1.

    Args:
        p_values: (K,).

    Raises:
        InputError: a value is not between 0 and 1.

    """
    p = np.asarray(p_values, np.float64)
    if p.ndim != 1 or not ((p >= 0) & (p <= 1)).all():
        raise InputError(f"expected p-values of shape (K,) from 0 to 1, got {p.tolist()}; pass one for each comparison")
    order = np.argsort(p, kind="stable")
    adjusted = np.empty_like(p)
    adjusted[order] = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1)).clip(max=1.0)
    return adjusted


def _flips(units: int) -> Iterator[NDArray[np.float64]]:
    """Yield which units are flipped, 0 or 1, in chunks (r, units): all choices for few units, else random ones."""
    exact = units <= EXACT_UNITS
    flips = 2**units if exact else FLIPS
    rows, rng = max(1, CHUNK // units), np.random.default_rng(0)
    for start in range(0, flips, rows):
        count = min(rows, flips - start)
        bits = _binary(start, count, units) if exact else rng.integers(0, 2, (count, units), np.int8)
        yield bits.astype(np.float64)


def _binary(start: int, count: int, digits: int) -> NDArray[np.integer]:
    """Return (count, digits) binary digits of the numbers from ``start`` on."""
    return np.arange(start, start + count)[:, None] >> np.arange(digits) & 1
