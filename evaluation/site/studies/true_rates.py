"""False and true positive rates of the statements of a comparison, from simulated comparisons.

    python -P -m indoor_explorers.evaluation.site.studies.true_rates

prints the tables of ``evaluation/STATISTICS.md`` in about three minutes on one core.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.evaluation.harness.experiment.experiment import MARGIN
from indoor_explorers.evaluation.statistics import CONFIDENCE, all_pairs_test, equivalence_test, significance

#: Steps after which an episode ends, and the mean of simulated times.
BUDGET, MEAN = 400.0, 55.0
#: Tasks of each building: single floors, and 36 floors of 26 buildings.
LAYOUTS: Mapping[str, tuple[int, ...]] = {
    "10": (1,) * 10,
    "30": (1,) * 30,
    "36 in 26": (7, 2, 2, 2, 2, *(1,) * 21),
    "100": (1,) * 100,
}
#: Simulated comparisons of each rate, and random flips of each test.
SIMULATIONS, FLIPS = 4000, 999
#: The mean, where it finishes, of a policy that fails in 2 % of episodes and has the restricted mean of the others.
QUICK = (1 - 0.02 * BUDGET / MEAN) / 0.98


class Sample(NamedTuple):
    """One simulated comparison of K policies on E tasks."""

    times: NDArray[np.float64]
    """(E, K) steps; the budget where not finished."""
    maps: NDArray[np.int64]
    """(E,) building of each task."""
    reached: NDArray[np.bool_]
    """(E, K)."""


class SimulatedPolicies(NamedTuple):
    """Policies whose times are the random length of a task, multiplied by a random factor of each policy."""

    ratios: Sequence[float]
    """(K,) mean of each policy, as a share of :data:`MEAN`."""
    failing: Sequence[float] = (0.0,)
    """(K,) or (1,) shares of episodes that do not finish."""
    noise: float = 0.12
    """Standard deviation on a task, as a share; two thirds of it once more in a building."""
    large: float = 0.0
    """By which share the last policy is slower in the first building; it is as much faster in the others in all."""
    skewed: bool = False
    """Whether the last policy's noise is lognormal, four times as large."""

    def sample(self, rng: np.random.Generator, sizes: Sequence[int]) -> Sample:
        """Draw the times of all policies on the same tasks."""
        maps = np.repeat(np.arange(len(sizes)), sizes)
        shape = len(maps), len(self.ratios)
        made = np.array(self.ratios) + rng.normal(0, self.noise, shape)
        made += rng.normal(0, self.noise * 2 / 3, (len(sizes), shape[1]))[maps]
        if self.skewed:
            wide = 4 * self.noise
            made[:, -1] = rng.lognormal(-(wide**2) / 2, wide, shape[0])
        made[:, -1] += np.where(maps == 0, self.large, -self.large * sizes[0] / (shape[0] - sizes[0]))
        times = MEAN * rng.lognormal(-0.08, 0.4, (shape[0], 1)) * made
        reached = rng.random(shape) >= np.array(self.failing)
        return Sample(np.where(reached, times, BUDGET), maps, reached)


def better(sample: Sample) -> NDArray[np.bool_]:
    """Return (K, K) which policy is called better than which."""
    return all_pairs_test(*sample).better()


def faster(sample: Sample) -> NDArray[np.bool_]:
    """Return (K, K) between which a difference of the times is called significant."""
    return np.asarray(all_pairs_test(*sample).adjusted_p <= 1 - CONFIDENCE)


def as_good(sample: Sample) -> NDArray[np.bool_]:
    """Return (1, K - 1) which policies are called as good as the first, tested as one family."""
    pairs = [(0, k) for k in range(1, sample.times.shape[1])]
    p = equivalence_test(sample.times, pairs, MARGIN, maps=sample.maps, reached=sample.reached)
    return np.asarray(p <= 1 - CONFIDENCE)[None]


class Case(NamedTuple):
    """A row of the table: a statement, and the world that is simulated."""

    world: SimulatedPolicies
    said: Callable[[Sample], NDArray[np.bool_]]
    by_first: bool = False
    """Whether only what is said about the first policy counts."""

    def rate(self, sizes: Sequence[int], simulations: int) -> float:
        """Return the share of simulated comparisons in which anything of the kind is said."""
        rng = np.random.default_rng(sum(sizes))
        with patch.object(significance, "FLIPS", FLIPS):
            said = [self.said(self.world.sample(rng, sizes)) for _ in range(simulations)]
        return float(np.mean([(each[:1] if self.by_first else each).any() for each in said]))


ONE = (1.0,) * 7
APART = (1.0, *[1 + MARGIN] * 6)
MIXED = (1.0, *3 * [1 + MARGIN], *3 * [1 / (1 + MARGIN)])
#: False statements, which at most 5 % of comparisons should make.
FALSE = {
    "2 equal policies: one is better": Case(SimulatedPolicies(ONE[:2]), better),
    "7 equal policies: any is better": Case(SimulatedPolicies(ONE), better),
    "the same, all fail in 2 %": Case(SimulatedPolicies(ONE, [0.02]), better),
    "the same, all fail in 5 %": Case(SimulatedPolicies(ONE, [0.05]), better),
    "the same, one fails in 2 %: it is better": Case(SimulatedPolicies(ONE, [0.02] + 6 * [0.0]), better, by_first=True),
    "the same, one fails in 5 %: it is better": Case(SimulatedPolicies(ONE, [0.05] + 6 * [0.0]), better, by_first=True),
    "the same, one fails in 5 %: any is faster": Case(SimulatedPolicies(ONE, [0.05] + 6 * [0.0]), faster),
    "2 with equal means, one 20 % slower on the first building": Case(SimulatedPolicies(ONE[:2], large=0.2), better),
    "2 with equal means, the times of one skewed": Case(SimulatedPolicies(ONE[:2], skewed=True), better),
    "2, one 5 % slower: as good within 5 %": Case(SimulatedPolicies(APART[:2], noise=0.02), as_good),
    "6, all 5 % slower than one: any as good as it": Case(SimulatedPolicies(APART, noise=0.02), as_good),
    "3 are 5 % slower, 3 faster: any as good as it": Case(SimulatedPolicies(MIXED, noise=0.02), as_good),
    "the same, all fail in 5 %: any as good as it": Case(SimulatedPolicies(MIXED, [0.05], noise=0.02), as_good),
}
#: True statements, and one that cannot be decided.
TRUE = {
    "2, one 10 % slower: it is worse": Case(SimulatedPolicies([1, 1.1]), better, by_first=True),
    "2, equal, noise 4 %: as good within 5 %": Case(SimulatedPolicies(ONE[:2], noise=0.04), as_good),
    "equal restricted means, one fails in 2 %: it is faster where both finish": Case(
        SimulatedPolicies([QUICK, 1], [0.02, 0.0]), better, by_first=True
    ),
}


def table(cases: Mapping[str, Case], simulations: int = SIMULATIONS) -> str:
    """Return the rates as the rows of a Markdown table."""
    rows = [["said", *LAYOUTS], ["---"] * (1 + len(LAYOUTS))]
    for name, case in cases.items():
        rates = [100 * case.rate(sizes, simulations) for sizes in LAYOUTS.values()]
        rows.append([name, *(f"{each:.1f} %" for each in rates)])
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


if __name__ == "__main__":
    print(table(FALSE), table(TRUE), sep="\n\n")  # noqa: T201 - a script
