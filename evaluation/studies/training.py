"""Runs one training for a command: finds the learner by its entry point, validates settings, shows the progress."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.errors import did_you_mean
from indoor_explorers.env.policies.registry import missing_module
from indoor_explorers.env.scenarios.validation import validated

#: Entry-point group of learners: modules with a ``TrainingConfig`` and a ``train``, which has a method ``finished``
#: (:class:`indoor_explorers.learners.sessions.train.TrainingMethod`).
GROUP = "indoor_explorers.learners"


def learner_entry_points() -> dict[str, EntryPoint]:
    """Return the installed learners by name."""
    return {entry.name: entry for entry in sorted(entry_points(group=GROUP), key=lambda entry: entry.name)}


def find_learner(name: str) -> Any:
    """Return the training module of a learner by name.

    Raises:
        InputError: there is no such learner, or what it needs is not installed.
    """
    known = learner_entry_points()
    if name not in known:
        raise InputError(f"unknown learner {name!r}{did_you_mean(name, known)}")
    try:
        return known[name].load()
    except ModuleNotFoundError as error:
        raise InputError(f"learner {name!r}: {missing_module(error)}") from error


def nested(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return settings with dotted keys as nested tables.

    Raises:
        InputError: a key is both a single setting and a table.
    """
    whole: dict[str, Any] = {}
    for key, value in settings.items():
        *parents, leaf = key.split(".")
        place: Any = whole
        for parent in parents:
            place = place.setdefault(parent, {})
            if not isinstance(place, dict):
                raise InputError(f"no setting {key!r}, since {parent!r} is a single one; set that")
        place[leaf] = place[leaf] | value if isinstance(value, dict) and isinstance(place.get(leaf), dict) else value
    return whole


def configured(learner: str, settings: Mapping[str, Any]) -> Any:
    """Return the configuration of a learner's training with settings by dotted keys.

    Raises:
        InputError: there is no such learner or setting.
    """
    return validated(find_learner(learner).TrainingConfig, nested(settings), f"settings of learner {learner!r}")


def preset_of(learner: str, name: str) -> Any:
    """Return a learner's preset: its ``scenario``, ``settings`` and ``seed``.

    Raises:
        InputError: the learner has no preset of that name.
    """
    presets = getattr(find_learner(learner), "PRESETS", {})
    if name not in presets:
        raise InputError(f"unknown preset {name!r} of learner {learner!r}{did_you_mean(name, presets)}")
    return presets[name]


def run_training(
    learner: str, scenario: Scenario | None, settings: Mapping[str, Any], *, out: Path, seed: int, resume: bool
) -> int:
    """Train a learner; show steps, speed, loss and evaluations; return the exit status."""
    module, config = find_learner(learner), configured(learner, settings)
    console = Console()
    columns = [TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), TimeRemainingColumn()]
    with Progress(*columns, console=console, disable=not console.is_terminal) as bar:
        line = bar.add_task("warming up", total=None)
        shown: list[Any] = []

        def show(progress: Any) -> None:
            bar.update(line, total=progress.total_steps, completed=progress.steps, description=_now(progress))
            if progress.evaluation and shown[-1:] != [progress.evaluation]:
                shown.append(progress.evaluation)
                figures = ", ".join(f"{name} {_short(value)}" for name, value in progress.evaluation.items())
                console.print(f"evaluation: {figures}", highlight=False)

        weights = module.train(config, scenario, out, seed=seed, resume=resume, report=show)
    console.print(f"Weights: {weights}", markup=False, highlight=False, soft_wrap=True)
    return 0


def _short(value: float) -> str:
    return f"{value:,}" if isinstance(value, int) else f"{value:.3g}"


def _now(progress: Any) -> str:
    epsilon = "" if progress.epsilon is None else f", epsilon {progress.epsilon:.2f}"
    made = f"{progress.steps / 1e6:.2f} M steps, {progress.steps_per_second:,.0f}/s"
    if progress.counted != "steps":
        made = f"{progress.steps:,} of {progress.total_steps:,} {progress.counted}"
    return f"{made}, loss {progress.loss:.4f}{epsilon}"
