"""The ``ablate`` command: train the missing variants, score the finished ones, write the table and the figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.scenarios.loading import named_scenario
from indoor_explorers.evaluation.studies.ablation.drawing import write_figure
from indoor_explorers.evaluation.studies.ablation.runs import runs_of
from indoor_explorers.evaluation.studies.ablation.scoring import score
from indoor_explorers.evaluation.studies.ablation.table import printed, write_table
from indoor_explorers.evaluation.studies.many_trainings import Failure, Training, train_all


def run_ablation(
    learner: str,
    scenario_name: str,
    out: Path,
    console: Console,
    *,
    patterns: Sequence[str],
    settings: Mapping[str, Any],
    seeds: int,
    jobs: int,
    episodes: int,
    command: str = "",
) -> list[Failure]:
    """Train the variants of a learner that match ``patterns``, and the full one, and compare them on unseen maps.

    Writes ``out/VARIANT/seed-S/`` for each training, ``judged/results.db``, ``ablation.csv`` and
    ``figures/ablation.{svg,png,pdf}``. Finished trainings and episodes are not repeated. After a Ctrl-C, table and
    figure are written from the finished ones. Returns the trainings that failed.

    Raises:
        InputError: there is no such learner, variant, scenario or setting, or ``out`` holds other trainings.

    """
    scenario = named_scenario(scenario_name)
    runs = runs_of(learner, scenario_name, scenario, patterns=patterns, settings=settings, seeds=seeds, out=out)
    try:
        out.mkdir(parents=True, exist_ok=True)
        try:
            failures = train_all(runs, jobs, lambda line: console.print(line, highlight=False, soft_wrap=True))
        except KeyboardInterrupt:
            console.print("interrupted; scoring the finished trainings, which another Ctrl-C skips")
            _conclude(runs, scenario, out, console, episodes, jobs, command)
            raise
        _conclude(runs, scenario, out, console, episodes, jobs, command)
    except OSError as error:
        raise InputError(
            f"{error.filename or out}: cannot be written: {error.strerror}; choose another --out"
        ) from error
    return failures


def _conclude(
    runs: Sequence[Training],
    scenario: Scenario,
    out: Path,
    console: Console,
    episodes: int,
    workers: int,
    command: str,
) -> None:
    """Score the finished trainings, and write and print the results."""
    found = score(runs, scenario, out, episodes=episodes, workers=workers, command=command)
    if not found:
        console.print(f"no training of {runs[0].variant!r}, which all others are compared with, is finished yet")
        return
    write_table(found, out / "ablation.csv")
    figure = write_figure(found, scenario.name, out / "figures")
    console.print(printed(found))
    console.print(f"Table: {out / 'ablation.csv'}", highlight=False, soft_wrap=True)
    console.print(f"Figure: {figure}", highlight=False, soft_wrap=True)
