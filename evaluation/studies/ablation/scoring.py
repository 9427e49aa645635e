"""Evaluates the trainings on the same unseen maps, and compares the variants."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.scenarios.seed_sets import seed_set
from indoor_explorers.evaluation.driver import fly_missing
from indoor_explorers.evaluation.harness.experiment.experiment import build_experiment
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.statistics import Estimate, difference_of_seeds, mean_of_seeds
from indoor_explorers.evaluation.studies.ablation.runs import TrainingRun, read_state
from indoor_explorers.evaluation.studies.training import find_learner

#: Folder of the evaluation episodes inside that of the ablation.
FLIGHTS = "judged"
#: File that a training writes, with its evaluations.
RECORD = "training.json"


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
    """For each training (2, K): moves made, and mean steps to the goal in the evaluation at that time."""

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
    runs: Sequence[TrainingRun], scenario: Scenario, out: Path, *, episodes: int, workers: int, command: str
) -> list[VariantScore]:
    """Fly the missing episodes of the finished trainings; return the variants in order, the full one first.

    The list is empty while no training of the full variant is finished.
    """
    finished = [run for run in runs if "weights" in read_state(run)]
    if not runs or not any(run.variant == runs[0].variant for run in finished):
        return []
    module, task = find_learner(runs[0].learner), scenario.for_evaluation()
    policies = [module.flown(_weights(run)) | {"name": run.title} for run in finished]
    experiment = build_experiment(policies, [task], episodes=episodes, seed=seed_set("ablation").first, settings={})
    fly_missing(experiment, out / FLIGHTS, ComparisonRequest(workers=workers), command=command)
    results = Results.load(out / FLIGHTS)
    names = dict.fromkeys(run.variant for run in runs)
    groups = [[run for run in finished if run.variant == name] for name in names]
    return [_score(group, results, task.name, episodes) for group in groups if group]


def _weights(run: TrainingRun) -> Path:
    return Path(run.folder) / str(read_state(run)["weights"])


def _score(runs: Sequence[TrainingRun], results: Results, scenario: str, episodes: int) -> VariantScore:
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
        never=float(np.mean([record.metrics.get("t99") is None for records in groups for record in records])),
        minutes=float(np.mean([read_state(run)["minutes"] for run in runs])),
        curves=[_curve(run) for run in runs],
    )


def _curve(run: TrainingRun) -> NDArray[np.float64]:
    path = Path(run.folder) / RECORD
    try:
        trials = json.loads(path.read_text(encoding="utf-8"))["evaluations"]
        return np.array([(trial["steps"], trial["t_goal"]) for trial in trials], np.float64).reshape(-1, 2).T
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"{path}: expected the record of a training, got something else ({error!r})") from error
