"""The ``thesis`` command: train the experiments in every version, one by one; write table, figures and page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

from rich.console import Console

from indoor_explorers.env import InputError
from indoor_explorers.env.files import writable
from indoor_explorers.evaluation.drawing.study_page import write_study_page
from indoor_explorers.evaluation.studies.many_trainings import Training, train_all, write_rows
from indoor_explorers.evaluation.studies.thesis.drawing import write_figures
from indoor_explorers.evaluation.studies.thesis.experiments import GROUPS, ThesisExperiment, chosen, versions
from indoor_explorers.evaluation.studies.thesis.results import COLUMNS, WEIGHTS, Run, read_run
from indoor_explorers.evaluation.studies.training import find_learner

#: The figures of a group with their captions.
FIGURES = {
    "scores": "The thesis's training curve: the first UAV's rewards summed over each episode, random moves included; "
    "black, its moving average over ten episodes or a hundredth of the training.",
    "coverage": "Left, as the thesis plots it: training episodes, which are left out of the mean once they have ended. "
    "Right, greedy episodes on maps not used in training; an episode that has ended keeps its coverage.",
    "greedy": "The network without random moves, for all UAVs, on maps not used in training.",
}


def write_page(runs: Sequence[Run], config: Any, folder: Path, path: Path) -> None:
    """Write the page with the figures of ``folder``; ``config`` is the class of the learner's settings."""
    write_study_page(
        "indoor_explorers.evaluation.studies.thesis",
        path,
        folder,
        experiments=_rows(runs),
        groups=[group for group in GROUPS.items() if any(run.experiment.group == group[0] for run in runs)],
        figures=FIGURES,
        switches=_switches(runs, config),
        facts=runs[0].record,
    )


def _rows(runs: Sequence[Run]) -> list[tuple[ThesisExperiment, list[dict[str, Any]]]]:
    """Return the experiments, each once, with the rows of their versions."""
    experiments = list(dict.fromkeys(run.experiment for run in runs))
    return [(one, [run.row() for run in runs if run.experiment == one]) for one in experiments]


def _switches(runs: Sequence[Run], config: Any) -> list[tuple[str, Any, str]]:
    """Return name, the thesis's value and the explanation of every setting that differs between the versions."""
    configs = [run.record["config"] for run in runs]
    own = {"episodes", "initial_weights", "evaluation_every", "checkpoint_every"}
    differing = [name for name in configs[0] if name not in own and any(c[name] != configs[0][name] for c in configs)]
    fields = config.model_fields
    return [(name, fields[name].default, " ".join(fields[name].description.split())) for name in differing]


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
    with writable(out, "--out"):
        write_rows(out / "summary.csv", COLUMNS, (run.row() for run in runs), lineterminator="\r\n")
        write_figures(runs, out / "figures")
        write_page(runs, config, out / "figures", out / "thesis.html")
