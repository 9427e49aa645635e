"""The gain on fresh episodes: the tuned policy against the default one, paired, with its interval."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.evaluation.drawing.formatting import seed_span
from indoor_explorers.evaluation.harness.episodes.metrics import TIMES
from indoor_explorers.evaluation.harness.results.ratios import Censoring
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.statistics import Block, Estimate, paired_ratios
from indoor_explorers.evaluation.studies.tuning.plan import Search

NONE_BETTER = "no gain shown: no trial was better than the default parameters on the tuning episodes"


@dataclass(frozen=True)
class Gain:
    """The metric of the tuned policy divided by that of the default one, on the same fresh episodes."""

    ratio: Estimate
    """Ratio of means, averaged over scenarios, with its 95 % interval."""
    episodes: int
    where: str
    """Which episodes."""
    lower_is_better: bool
    title: str
    """Name of the metric."""
    never: Censoring | None
    """How often a time was never reached; None for other metrics."""

    @classmethod
    def of(cls, search: Search, results: Results, tuned: str) -> Gain:
        """Compare the policy called ``tuned`` with the default one."""
        default, metric = search.space.choice.name, search.request.metric
        blocks = [_block(results, each.name, tuned, default, metric) for each in search.fresh.scenarios]
        (ratio,) = paired_ratios(blocks)
        reached = [
            [results.reached(each.name, name, metric) for name in (tuned, default)] for each in search.fresh.scenarios
        ]
        return cls(
            ratio.of_means,
            sum(len(block.maps) for block in blocks),
            _where(search),
            search.measure.lower_is_better,
            search.measure.title,
            None if metric not in TIMES else Censoring.sum(Censoring.of(*pair) for pair in reached),
        )

    @property
    def verdict(self) -> str:
        """What the interval shows."""
        low, high = self.ratio.low, self.ratio.high
        if low is None or high is None:
            return "too few episodes for an interval, no gain shown"
        if low <= 1.0 <= high:
            return "no gain shown"
        return "a gain is shown" if (high < 1.0) == self.lower_is_better else "a loss is shown"

    @property
    def line(self) -> str:
        """The gain in a line."""
        mean, low, high = self.ratio
        interval = "" if low is None or high is None else f" [{low:.3f}, {high:.3f}]"
        return (
            f"tuned / default on {self.episodes} fresh episodes ({self.where}): {self.title} {mean:.3f}{interval}, "
            f"paired, 95 %: {self.verdict}"
        )


def _block(results: Results, scenario: str, tuned: str, default: str, metric: str) -> Block:
    """Return one scenario, in units of the default's mean, so that each scenario counts the same."""
    above, below = (_positive(results.values(scenario, name, metric), metric) for name in (tuned, default))
    scale = below.mean()
    return Block(above[:, None] / scale, below[:, None] / scale, results.maps(scenario, default))


def _positive(values: NDArray[np.float64], metric: str) -> NDArray[np.float64]:
    """Return times of at least a step, as in the ratios of a comparison; other metrics as they are."""
    return np.maximum(values, 1.0) if metric in TIMES else values


def _where(search: Search) -> str:
    fresh = search.fresh
    if search.generated:
        return seed_span(range(fresh.seed, fresh.seed + fresh.episodes))
    if search.request.suite is not None:
        return "the other part of the suite"
    return f"the same maps, {seed_span(range(fresh.seed, fresh.seed + fresh.episodes))}"
