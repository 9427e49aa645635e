"""Steps of each policy divided by those of a baseline policy, by scenario and over all of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.experiment.selection import chosen_baselines
from indoor_explorers.evaluation.harness.results.coverage_threshold import drawn
from indoor_explorers.evaluation.harness.results.results import Results, write_csv
from indoor_explorers.evaluation.statistics import Block, Estimate, PairedRatio, paired_ratios

#: Name of all scenarios together in tables.
POOLED = "all scenarios"
FIGURES = ("mean_of_ratios", "low", "high", "ratio_of_means", "ratio_of_means_low", "ratio_of_means_high")
NEVER = ("never_policy", "never_baseline", "never_both", "bound")
COLUMNS = ("scenario", "policy", "to", "metric", "scenarios", "tasks", *FIGURES, *NEVER)
#: Least share of pairs in which both reached the threshold for a figure that enters an average over scenarios.
LEAST_REACHED = 0.95
#: Stands where there is no ratio.
NO_RATIO = PairedRatio(*[Estimate(float("nan"), None, None)] * 2)


class Censoring(NamedTuple):
    """In how many of the pairs a threshold was never reached, where the budget takes the place of the steps."""

    pairs: int
    above: int
    """Pairs in which the policy never reached it and the baseline did: the ratio is a lower bound."""
    below: int
    """Pairs in which the baseline alone never reached it: the ratio is an upper bound."""
    both: int
    """Pairs in which neither did, which have no ratio."""

    @classmethod
    def of(cls, ours: NDArray[np.bool_], theirs: NDArray[np.bool_]) -> Censoring:
        """Count from (E,) whether each of the two reached it."""
        counts = (~ours & theirs, ours & ~theirs, ~ours & ~theirs)
        return cls(len(ours), *(int(each.sum()) for each in counts))

    @classmethod
    def sum(cls, parts: Iterable[Censoring]) -> Censoring:
        """Add the counts of several scenarios."""
        return cls(*(sum(counts) for counts in zip(*parts, strict=True)))

    @property
    def mostly_reached(self) -> bool:
        """Whether both reached the threshold in nearly all pairs."""
        return self.pairs - self.above - self.below - self.both >= LEAST_REACHED * self.pairs

    @property
    def bound(self) -> str | None:
        """Kind of a ratio of steps: ``>`` a lower bound, ``<`` an upper one, empty an exact one, None undefined."""
        if not (self.below or self.both):
            return ">" if self.above else ""
        if not (self.above or self.both):
            return "<"
        return "\N{ALMOST EQUAL TO}" if self.mostly_reached else None


@dataclass(frozen=True)
class RatioRow:
    """One policy's steps to a threshold divided by another's, on the tasks that all policies flew."""

    scenario: str
    """Its name, or :data:`POOLED`."""
    policy: str
    to: str
    metric: str
    """One of :attr:`Ratios.metrics`."""
    scenarios: int
    """Number of scenarios."""
    tasks: int
    ratio: PairedRatio
    """NaN where the budget decides it: neither policy, or now one and now the other, never reached the threshold."""
    censoring: Censoring

    def cells(self) -> dict[str, Any]:
        """Return the row of ratios.csv."""
        names = (self.scenario, self.policy, self.to, self.metric, self.scenarios, self.tasks)
        never = (*self.censoring[1:], self.censoring.bound)
        return dict(zip(COLUMNS, (*names, *self.ratio.of_tasks, *self.ratio.of_means, *never), strict=True))


@dataclass(frozen=True, eq=False)
class Ratios:
    """All ratios of results to some baseline policies."""

    results: Results
    to: Sequence[str]

    @classmethod
    def of(cls, results: Results, asked: Sequence[str] | None = None) -> Ratios:
        """Use the baselines asked for, or the default ones; see :func:`chosen_baselines`."""
        return cls(results, chosen_baselines(list(results.policies), results.privileged_policies, asked))

    @property
    def metrics(self) -> tuple[str, ...]:
        """The times that are compared: T90, and those to the thresholds of the scenarios."""
        return drawn(self.results.levels)

    @cached_property
    def rows(self) -> list[RatioRow]:
        """By baseline, time and scenario, all scenarios together last; policies in the experiment's order."""
        return [row for to in self.to for metric in self.metrics for row in self._rows(to, metric)]

    def _rows(self, to: str, metric: str) -> list[RatioRow]:
        flown = [name for name in self.results.scenarios if self._counts(name, to, metric)]
        rows = [row for name in flown for row in self.of_scenario(name, to, metric)]
        return rows + (self._pooled(flown, to, metric) if len(flown) > 1 else [])

    def of_scenario(self, scenario: str, to: str, metric: str) -> list[RatioRow]:
        """Compare the policies on one scenario with one that flew it."""
        return self._family([scenario], scenario, to, metric)

    def _counts(self, scenario: str, to: str, metric: str) -> bool:
        """Return whether there is something to compare: common tasks, and a goal not below the threshold."""
        asked = self.results.applies_to(scenario, metric)
        return asked and (scenario, to) in self.results.groups and bool(self._tasks[scenario])

    @cached_property
    def _tasks(self) -> dict[str, list[Task]]:
        """The tasks of each scenario that all its policies flew, in order."""
        return {name: sorted(self.results.common_tasks(name)) for name in self.results.scenarios}

    def _others(self, scenarios: Sequence[str], to: str) -> list[str]:
        """Return the policies but the baseline that flew all the scenarios."""
        groups = self.results.groups
        return [
            name for name in self.results.policies if name != to and all((each, name) in groups for each in scenarios)
        ]

    def _pooled(self, scenarios: Sequence[str], to: str, metric: str) -> list[RatioRow]:
        """Compare over the scenarios in which a policy and the baseline nearly always reach the threshold."""
        kept = {
            name: tuple(each for each in scenarios if self._censoring(each, name, to, metric).mostly_reached)
            for name in self._others(scenarios, to)
        }
        rows = {
            row.policy: row
            for chosen in dict.fromkeys(kept.values())
            if chosen
            for row in self._family(chosen, POOLED, to, metric, [name for name in kept if kept[name] == chosen])
        }
        return [rows[name] for name in kept if name in rows]

    def _family(
        self, scenarios: Sequence[str], title: str, to: str, metric: str, policies: Sequence[str] | None = None
    ) -> list[RatioRow]:
        """Compare policies, by default all that flew all the scenarios, from one set of resamples."""
        names = self._others(scenarios, to) if policies is None else policies
        if not names:
            return []
        blocks = [self._block(scenario, names, to, metric) for scenario in scenarios]
        tasks = sum(len(block.maps) for block in blocks)
        never = {name: Censoring.sum(self._censoring(each, name, to, metric) for each in scenarios) for name in names}
        return [
            RatioRow(title, name, to, metric, len(scenarios), tasks, NO_RATIO if found.bound is None else ratio, found)
            for (name, found), ratio in zip(never.items(), paired_ratios(blocks), strict=True)
        ]

    def _censoring(self, scenario: str, policy: str, to: str, metric: str) -> Censoring:
        ours, theirs = (
            self.results.reached(scenario, name, metric)[self._places(scenario, name)] for name in (policy, to)
        )
        return Censoring.of(ours, theirs)

    def _block(self, scenario: str, names: Sequence[str], to: str, metric: str) -> Block:
        above = np.stack([self._steps(scenario, name, metric) for name in names], axis=1)
        below = np.broadcast_to(self._steps(scenario, to, metric)[:, None], above.shape)
        return Block(above, below, self.results.maps(scenario, to)[self._places(scenario, to)])

    def _steps(self, scenario: str, policy: str, metric: str) -> NDArray[np.float64]:
        """Return (E,) steps on the common tasks; a threshold reached at the start counts as one step."""
        values = self.results.values(scenario, policy, metric)[self._places(scenario, policy)]
        return np.maximum(values, 1.0)

    def _places(self, scenario: str, policy: str) -> list[int]:
        place = {record.task: k for k, record in enumerate(self.results.groups[scenario, policy])}
        return [place[task] for task in self._tasks[scenario]]


def write_ratios(ratios: Ratios, path: Path) -> None:
    """Write ratios.csv; equal results give equal bytes."""
    write_csv(pd.DataFrame([row.cells() for row in ratios.rows], columns=list(COLUMNS)), path, "%.6g")
