"""Runs the thesis's experiments one after the other; skips finished ones and resumes interrupted ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from indoor_explorers.env import InputError
from indoor_explorers.env.scenarios.loading import named_scenario
from indoor_explorers.env.scenarios.validation import validated
from indoor_explorers.evaluation.studies.thesis.drawing import write_figures
from indoor_explorers.evaluation.studies.thesis.experiments import ThesisExperiment, chosen, versions
from indoor_explorers.evaluation.studies.thesis.page import write_page
from indoor_explorers.evaluation.studies.thesis.results import WEIGHTS, Run, read_run, write_summary
from indoor_explorers.evaluation.studies.training import find_learner, run_training

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
    experiments = chosen(patterns)
    runs = []
    for experiment in experiments:
        for version, switches in flown.items():
            own = {**settings, **switches, **_pace(experiment.episodes(episodes), settings)}
            if experiment.starts_from is not None:
                own["initial_weights"] = str((out / experiment.starts_from / version / WEIGHTS).resolve())
            runs.append(_trained(experiment, version, own, out / experiment.name / version, seed, console))
    _write(runs, out, learner.TrainingConfig)
    return runs


def _pace(episodes: int, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the number of episodes, and the distances of evaluations and checkpoints unless they are set."""
    pace = {
        "evaluation_every": max(1, episodes // EVALUATIONS),
        "checkpoint_every": max(1, episodes // CHECKPOINTS),
    }
    return {"episodes": episodes} | {name: value for name, value in pace.items() if name not in settings}


def _trained(
    experiment: ThesisExperiment, version: str, settings: Mapping[str, Any], folder: Path, seed: int, console: Console
) -> Run:
    """Return a training; run it if it is not finished."""
    run = read_run(experiment, version, folder)
    if run is None:
        console.print(f"{experiment.name}, {version}: {settings['episodes']} episodes", highlight=False)
        scenario = named_scenario(experiment.scenario)
        run_training(LEARNER, scenario, settings, out=folder, seed=seed, resume=True)
        run = read_run(experiment, version, folder)
        assert run is not None
    else:
        _refuse_others(run, settings, folder, seed)
    return run


def _refuse_others(run: Run, settings: Mapping[str, Any], folder: Path, seed: int) -> None:
    """Refuse a finished training with other settings than those asked for."""
    kind = find_learner(LEARNER).TrainingConfig
    config = validated(kind, dict(settings), f"settings of learner {LEARNER!r}")
    defaults = kind().model_dump(mode="json")  # of settings that there were not yet
    mine = {"seed": seed, **config.model_dump(mode="json")}
    for name, value in mine.items():
        found = run.record["seed"] if name == "seed" else run.record["config"].get(name, defaults[name])
        if found != value:
            raise InputError(
                f"{folder} holds a training with {name} {found}, expected {value}; give the same settings as then, "
                "or another --out"
            )


def _write(runs: Sequence[Run], out: Path, config: Any) -> None:
    try:
        write_summary(runs, out / "summary.csv")
        write_figures(runs, out / "figures")
        write_page(runs, config, out / "figures", out / "thesis.html")
    except OSError as error:
        raise InputError(
            f"{error.filename or out}: cannot be written: {error.strerror}; choose another --out"
        ) from error
