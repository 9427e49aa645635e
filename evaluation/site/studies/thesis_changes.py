"""The thesis's learner with two changes, apart and together: a row of ``thesis_changes.csv`` for each training.

Written manually from folders of ``indoor-explorers thesis --only rewards-1-stuck-2 --episodes 1000``, with ``--seed``,
``--versions`` and ``--set`` as THESIS.md tells::

    python -P -m indoor_explorers.evaluation.site.studies.thesis_changes results/both-1 results/both-2 ...

Lists are separated by spaces.
"""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.evaluation.drawing.formatting import percent
from indoor_explorers.evaluation.site.studies.thesis import EVALUATED, VERSIONS, numbers, text
from indoor_explorers.evaluation.studies.many_trainings import write_rows
from indoor_explorers.evaluation.studies.thesis.experiments import EXPERIMENTS
from indoor_explorers.evaluation.studies.thesis.results import Run, read_run
from indoor_explorers.learners.thesis.config import TrainingConfig

MEASURED = Path(__file__).parent / "thesis_changes.csv"
EXPERIMENT = next(experiment for experiment in EXPERIMENTS if experiment.name == "rewards-1-stuck-2")
#: The settings that are changed, besides the switches of the mistakes.
CHANGES = ("centred", "terminal_reward")
UNCHANGED = TrainingConfig().model_dump()
COLUMNS = ("version", *CHANGES, "seed", "command", "commit", *(f"at_{name}" for name in EVALUATED))
#: The last evaluations, over which the table takes the mean.
LAST = 5


class ChangedTraining(NamedTuple):
    """A training of the file."""

    version: str
    changes: tuple[str, ...]
    """Those of :data:`CHANGES` that were made."""
    seed: int
    greedy: dict[str, NDArray[np.float64]]
    """Figures of all greedy evaluations, and the numbers of training ``episodes`` before them."""


def measured() -> tuple[ChangedTraining, ...]:
    """Return the trainings of the file."""
    with MEASURED.open(newline="", encoding="utf-8") as file:
        return tuple(
            ChangedTraining(
                row["version"],
                tuple(name for name in CHANGES if row[name]),
                int(row["seed"]),
                {name: numbers(row[f"at_{name}"]) for name in EVALUATED},
            )
            for row in csv.DictReader(file)
        )


def results_table() -> list[str]:
    """Return the rows of a table in Markdown: of each training the means over its last evaluations."""
    rows = []
    for training in measured():
        made = ["yes" if name in training.changes else "" for name in CHANGES]
        shares = [percent(training.greedy[name][-LAST:].mean()) for name in EVALUATED[1:]]
        rows.append(f"| {' | '.join([f'`{training.version}`', *made, str(training.seed), *shares])} |")
    return rows


def rows(folders: Sequence[Path]) -> Iterator[dict[str, Any]]:
    """Yield the rows of the file: the finished trainings of some folders, the unchanged version first."""
    found = []
    for folder in folders:
        for version in VERSIONS:
            run = read_run(EXPERIMENT, version, folder / EXPERIMENT.name / version)
            if run is not None:
                found.append((VERSIONS.index(version), _changes(run), run.record["seed"], run))
    for _, changes, seed, run in sorted(found, key=lambda each: (each[0], len(each[1]), each[1:3])):
        config = run.record["config"]
        made = {name: config[name] for name in changes}
        settings = " ".join(f"{name}={json.dumps(value)}" for name, value in made.items())
        options = f"--only {EXPERIMENT.name} --episodes {len(run.scores)} --versions {run.version} --seed {seed}"
        command = f"indoor-explorers thesis {options}" + (f" --set {settings}" if made else "")
        row = {"version": run.version, **made, "seed": seed, "command": command, "commit": run.record["commit"][:7]}
        yield row | {f"at_{name}": text(run.greedy(name), ".4g") for name in EVALUATED}


def _changes(run: Run) -> tuple[str, ...]:
    return tuple(name for name in CHANGES if run.record["config"].get(name, UNCHANGED[name]) != UNCHANGED[name])


def main(folders: Sequence[str], out: Path = MEASURED) -> None:
    """Write the file."""
    write_rows(out, COLUMNS, rows([Path(folder) for folder in folders]))


if __name__ == "__main__":
    main(sys.argv[1:])
