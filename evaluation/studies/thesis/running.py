"""The ``thesis`` command: train every experiment in every version, one after the other, and write table and page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

from rich.console import Console

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.studies.many_trainings import Training, train_all
from indoor_explorers.evaluation.studies.thesis.drawing import write_figures
from indoor_explorers.evaluation.studies.thesis.experiments import ThesisExperiment, chosen, versions
from indoor_explorers.evaluation.studies.thesis.page import write_page
from indoor_explorers.evaluation.studies.thesis.results import WEIGHTS, Run, read_run, write_summary
from indoor_explorers.evaluation.studies.training import find_learner

LEARNER = "dddqn-thesis"
#: Number of greedy evaluations and of checkpoints in a training.
EVALUATIONS, CHECKPOINTS = 20, 5


def run_thesis(
    out: Path,
    console: Console,
    *,
    episodes: int,
    version_names: Sequence[str],
    patterns: Sequence[str],
    settings: Mapping[str, Any],
    seed: int,
) -> list[Run]:
    """Run the experiments that match ``patterns`` in the named versions and write the results into ``out``.

    Writes a folder for each training, ``summary.csv``, ``figures/`` and ``thesis.html``; returns the trainings.

    Raises:
        InputError: there is no such experiment, version or setting, or ``out`` holds a training that differs.

    """
    learner = find_learner(LEARNER)
    flown = versions(version_names, learner.MENDED)
    trainings = {
        (experiment, version): _training(experiment, version, {**settings, **flown[version]}, out, episodes, seed)
        for experiment, version in product(chosen(patterns), flown)
    }
    failures = train_all([*trainings.values()], 1, lambda line: console.print(line, highlight=False))
    if failures:
        raise InputError(f"{failures[0].training.title}: {failures[0].reason}")
    runs = [read_run(*key, Path(training.folder)) for key, training in trainings.items()]
    finished = [run for run in runs if run is not None]  # all are
    _write(finished, out, learner.TrainingConfig)
    return finished


def _training(
    experiment: ThesisExperiment, version: str, settings: Mapping[str, Any], out: Path, episodes: int, seed: int
) -> Training:
    """Return the training of an experiment in one version; teams start from the weights of a single UAV."""
    own = {**settings, **_pace(experiment.episodes(episodes), settings)}
    if experiment.starts_from is not None:
        own["initial_weights"] = str((out / experiment.starts_from / version / WEIGHTS).resolve())
    folder = str(out / experiment.name / version)
    return Training(LEARNER, experiment.scenario, f"{experiment.name}, {version}", seed, own, folder)


def _pace(episodes: int, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the number of episodes, and the distances of evaluations and checkpoints unless they are set."""
    pace = {
        "evaluation_every": max(1, episodes // EVALUATIONS),
        "checkpoint_every": max(1, episodes // CHECKPOINTS),
    }
    return {"episodes": episodes} | {name: value for name, value in pace.items() if name not in settings}


def _write(runs: Sequence[Run], out: Path, config: Any) -> None:
    try:
        write_summary(runs, out / "summary.csv")
        write_figures(runs, out / "figures")
        write_page(runs, config, out / "figures", out / "thesis.html")
    except OSError as error:
        raise InputError(
            f"{error.filename or out}: cannot be written: {error.strerror}; choose another --out"
        ) from error
