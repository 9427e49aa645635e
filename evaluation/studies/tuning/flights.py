"""The tuning episodes of a search: flown by the harness, each once, and read from a store for each trial.

So a look at a trial takes as long after thousands of trials as after one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.evaluation.driver import fly_missing
from indoor_explorers.evaluation.harness.engines.factory import Engine
from indoor_explorers.evaluation.harness.experiment.experiment import PolicyChoice, Task
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.studies.tuning.plan import Search

#: Folder of the stores in that of the search, and of the default's among them.
FLIGHTS, DEFAULT = "flights", "default"


@dataclass
class Flights:
    """Flies trials on the tuning episodes of a search, in their order."""

    search: Search
    engine: Engine
    command: str = ""
    _scales: dict[str, float] = field(default_factory=dict)
    """The mean of the default parameters by scenario."""
    maps: Sequence[str] = ()
    """(E,) the map of each episode, once the default was flown."""

    def _folder(self, choice: PolicyChoice) -> Path:
        name = DEFAULT if choice == self.search.space.choice else choice.name
        return self.search.request.out / FLIGHTS / name

    def fly_default(self) -> None:
        """Fly the default parameters, in whose mean by scenario all values are given."""
        search = self.search
        results = self._flown(search.space.choice, search.tasks)
        name, metric = search.space.choice.name, search.request.metric
        self._scales = {each.name: _scale(results, each.name, name, metric) for each in search.tuning.scenarios}
        labels = {
            record.task: label
            for each in search.tuning.scenarios
            for record, label in zip(results.groups[each.name, name], results.maps(each.name, name), strict=True)
        }
        self.maps = [str(labels[task]) for task in search.tasks]

    def values(self, choice: PolicyChoice, count: int) -> NDArray[np.float64]:
        """Return the values of a trial on the first ``count`` episodes, relative to the default's mean."""
        tasks = self.search.tasks[:count]
        results = self._flown(choice, tasks)
        found: dict[Task, float] = {}
        for scenario in dict.fromkeys(task.scenario for task in tasks):
            values = results.values(scenario, choice.name, self.search.request.metric) / self._scales[scenario]
            records = results.groups[scenario, choice.name]
            found |= {record.task: value for record, value in zip(records, values.tolist(), strict=True)}
        return np.array([found[task] for task in tasks])

    def _flown(self, choice: PolicyChoice, tasks: Sequence[Task]) -> Results:
        fly_missing(
            self.search.tuning.model_copy(update={"policies": (choice,)}),
            self._folder(choice),
            ComparisonRequest(workers=self.search.request.workers),
            command=self.command,
            only=tasks,
            engine=self.engine,
        )
        return Results.load(self._folder(choice))


def _scale(results: Results, scenario: str, policy: str, metric: str) -> float:
    return float(results.values(scenario, policy, metric).mean()) or 1.0
