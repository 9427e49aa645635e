"""Reads the finished trainings of the thesis's experiments from their folders."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.studies.thesis.experiments import ThesisExperiment

#: Files of a training, see :mod:`indoor_explorers.learners.thesis.train`.
RECORD, EPISODES, WEIGHTS = "training.json", "episodes.csv", "weights.safetensors"
#: Columns of ``summary.csv``; those from ``coverage`` on are of the last greedy evaluation.
COLUMNS = (
    *("experiment", "version", "scenario", "team", "episodes", "seed", "minutes", "thesis_minutes"),
    *("training_score", "training_positive", "coverage", "t90", "reached", "crashed", "stuck"),
)


class Run(NamedTuple):
    """One finished training."""

    experiment: ThesisExperiment
    version: str
    record: dict[str, Any]
    scores: NDArray[np.float64]
    """(E,) scores of the training episodes, with exploration."""

    def greedy(self, figure: str) -> NDArray[np.float64]:
        """Return one figure of all greedy evaluations; ``episodes`` is the number of training episodes before each."""
        return np.array([evaluation[figure] for evaluation in self.record["evaluations"]], np.float64)

    @property
    def team(self) -> int:
        """Number of UAVs."""
        return int(self.record["scenario"]["team"])

    def row(self) -> dict[str, Any]:
        """Return the run's row of the table; training figures are means over the last tenth of the episodes."""
        last = self.scores[-max(1, len(self.scores) // 10) :]
        final = self.record["evaluations"][-1]
        return {
            "experiment": self.experiment.name,
            "version": self.version,
            "scenario": self.experiment.scenario,
            "team": self.team,
            "episodes": len(self.scores),
            "seed": self.record["seed"],
            "minutes": round(self.record["seconds"] / 60, 2),
            "thesis_minutes": self.experiment.minutes,
            "training_score": round(float(last.mean()), 2),
            "training_positive": round(float((last > 0).mean()), 4),
        } | {name: round(final[name], 4) for name in COLUMNS[-5:]}


def read_run(experiment: ThesisExperiment, version: str, folder: Path) -> Run | None:
    """Return the finished training of a folder, None if there is none.

    Raises:
        InputError: its files are damaged.

    """
    if not (folder / RECORD).is_file():
        return None
    try:
        record = json.loads((folder / RECORD).read_text(encoding="utf-8"))
        if not record["done"]:
            return None
        with (folder / EPISODES).open(newline="", encoding="utf-8") as file:
            scores = np.array([float(row["score"]) for row in csv.DictReader(file)])
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"{folder}: expected a finished training, got something else ({error!r}); delete it"
        ) from error
    return Run(experiment, version, record, scores)
