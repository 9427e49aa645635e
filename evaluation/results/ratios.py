"""Steps of each policy divided by those of a baseline policy, by scenario and over all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from indoor_explorers.env.files import written_whole
from indoor_explorers.evaluation.experiment.experiment import Task
from indoor_explorers.evaluation.experiment.selection import chosen_baselines
from indoor_explorers.evaluation.results.coverage_threshold import drawn
from indoor_explorers.evaluation.results.results import Results
from indoor_explorers.evaluation.statistics import Block, PairedRatio, paired_ratios

#: Name of all scenarios together in tables.
POOLED = "all scenarios"
FIGURES = ("mean_of_ratios", "low", "high", "ratio_of_means", "ratio_of_means_low", "ratio_of_means_high")
COLUMNS = ("scenario", "policy", "to", "metric", "scenarios", "tasks", *FIGURES)


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

    def cells(self) -> dict[str, Any]:
        """Return the row of ratios.csv."""
        names = (self.scenario, self.policy, self.to, self.metric, self.scenarios, self.tasks)
        return dict(zip(COLUMNS, (*names, *self.ratio.of_tasks, *self.ratio.of_means), strict=True))


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
        rows = [row for name in flown for row in self._family([name], name, to, metric)]
        return rows + (self._family(flown, POOLED, to, metric) if len(flown) > 1 else [])

    def _counts(self, scenario: str, to: str, metric: str) -> bool:
        """Return whether there is something to compare: common tasks, and a goal not below the threshold."""
        asked = self.results.applies_to(scenario, metric)
        return asked and (scenario, to) in self.results.groups and bool(self._tasks[scenario])

    @cached_property
    def _tasks(self) -> dict[str, list[Task]]:
        """The tasks of each scenario that all its policies flew."""
        flown: dict[str, list[set[Task]]] = {name: [] for name in self.results.scenarios}
        for (scenario, _), records in self.results.groups.items():
            flown[scenario].append({record.task for record in records})
        return {name: sorted(set.intersection(*tasks)) if tasks else [] for name, tasks in flown.items()}

    def _family(self, scenarios: Sequence[str], title: str, to: str, metric: str) -> list[RatioRow]:
        """Compare every policy that flew all the scenarios, from one set of resamples."""
        groups = self.results.groups
        names = [
            name for name in self.results.policies if name != to and all((each, name) in groups for each in scenarios)
        ]
        if not names:
            return []
        blocks = [self._block(scenario, names, to, metric) for scenario in scenarios]
        tasks = sum(len(block.maps) for block in blocks)
        return [
            RatioRow(title, name, to, metric, len(scenarios), tasks, ratio)
            for name, ratio in zip(names, paired_ratios(blocks), strict=True)
        ]

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
    table = pd.DataFrame([row.cells() for row in ratios.rows], columns=list(COLUMNS))
    with written_whole(path) as partial:
        table.to_csv(partial, index=False, float_format="%.6g", lineterminator="\n")
