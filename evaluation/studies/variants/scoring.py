"""Flies the trained networks of a study on the same unseen maps, and averages the times of each variant."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import Scenario
from indoor_explorers.env.scenarios.seed_sets import seed_set
from indoor_explorers.evaluation.driver import fly_missing
from indoor_explorers.evaluation.harness.experiment.experiment import build_experiment
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.statistics import Estimate, difference_of_seeds, mean_of_seeds
from indoor_explorers.evaluation.studies.many_trainings import Training
from indoor_explorers.evaluation.studies.training import find_learner

#: Folder of the evaluation episodes inside that of the study.
FLIGHTS = "judged"


@dataclass(frozen=True, kw_only=True, eq=False)
class VariantScore:
    """The finished trainings of one variant."""

    variant: str
    settings: dict[str, Any]
    """Settings that differ from the learner's defaults, by dotted keys."""
    seeds: list[int]
    """Seeds of its S trainings."""
    times: dict[str, NDArray[np.float64]]
    """(S, E) ``t90`` and ``t99``: steps to 90 and 99 %, the budget where these were never reached."""
    never: float
    """Share of the episodes that never reached 99 %."""
    minutes: float
    """Mean training time."""
    curves: list[NDArray[np.float64]]
    """For each training (2, K): moves made, and mean steps to the goal in the evaluation at that time; K is 0 for
    learners that do not evaluate these."""

    def mean(self, metric: str) -> Estimate:
        """Return the mean of a time over trainings and episodes."""
        return mean_of_seeds(self.times[metric])

    def against(self, full: VariantScore, metric: str) -> Estimate:
        """Return the mean difference in steps to another variant."""
        return difference_of_seeds(self.times[metric], full.times[metric])

    def dots(self, full: VariantScore, metric: str) -> NDArray[np.float64]:
        """Return (S,) the differences of each training's mean to the mean of the other variant."""
        return np.asarray(self.times[metric].mean(axis=1) - full.times[metric].mean())


def score(
    runs: Sequence[Training], scenario: Scenario, out: Path, *, episodes: int, workers: int, command: str
) -> list[VariantScore]:
    """Fly the missing episodes of the finished trainings; return the variants in order, without unfinished ones."""
    finished = [(run, record) for run in runs if (record := run.finished()) is not None]
    if not finished:
        return []
    module, task = find_learner(runs[0].learner), scenario.for_evaluation()
    policies = [module.flown(Path(run.folder) / module.train.weights) | {"name": run.title} for run, _ in finished]
    experiment = build_experiment(policies, [task], episodes=episodes, seed=seed_set("ablation").first, settings={})
    fly_missing(experiment, out / FLIGHTS, ComparisonRequest(workers=workers), command=command)
    results = Results.load(out / FLIGHTS)
    names = dict.fromkeys(run.variant for run in runs)
    groups = [[each for each in finished if each[0].variant == name] for name in names]
    return [_score(group, results, task.name, episodes) for group in groups if group]


def _score(group: Sequence[tuple[Training, Any]], results: Results, scenario: str, episodes: int) -> VariantScore:
    """Return the score of one variant from its finished trainings."""
    runs, records = zip(*group, strict=True)
    titles = [run.title for run in runs]
    groups = [results.groups[scenario, title][:episodes] for title in titles]
    return VariantScore(
        variant=runs[0].variant,
        settings=runs[0].settings,
        seeds=[run.seed for run in runs],
        times={
            metric: np.stack([results.values(scenario, title, metric)[:episodes] for title in titles])
            for metric in ("t90", "t99")
        },
        never=float(np.mean([flown.metrics.get("t99") is None for flights in groups for flown in flights])),
        minutes=float(np.mean([record.minutes for record in records])),
        curves=[_curve(record) for record in records],
    )


def _curve(record: Any) -> NDArray[np.float64]:
    """Return (2, K) the moves before each evaluation, and its mean steps to the goal."""
    trials = [(trial["steps"], trial["t_goal"]) for trial in record.evaluations if "t_goal" in trial]
    return np.array(trials, np.float64).reshape(-1, 2).T
