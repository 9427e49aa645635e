"""The ``ablate`` command: train the missing variants, score the finished ones, write the table and the figure."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.files import writable
from indoor_explorers.env.scenarios.loading import named_scenario
from indoor_explorers.evaluation.statistics import Estimate
from indoor_explorers.evaluation.studies.ablation.drawing import write_figure
from indoor_explorers.evaluation.studies.ablation.scoring import VariantScore, score
from indoor_explorers.evaluation.studies.many_trainings import Failure, Training, matching, train_all, write_rows
from indoor_explorers.evaluation.studies.training import find_learner

METRICS = ("t90", "t99")
COLUMNS = (
    *("variant", "seeds"),
    *(f"{metric}{end}" for metric in METRICS for end in ("", "_low", "_high")),
    "never_99_percent",
    *(f"{metric}_to_full{end}" for metric in METRICS for end in ("", "_low", "_high")),
    *("minutes", "settings"),
)


def row(variant: VariantScore, full: VariantScore) -> dict[str, Any]:
    """Return the row of a variant; for the full one, differences are empty."""
    cells: dict[str, Any] = {"variant": variant.variant, "seeds": len(variant.seeds)}
    for metric in METRICS:
        cells |= _cells(metric, variant.mean(metric))
        if variant is not full:
            cells |= _cells(f"{metric}_to_full", variant.against(full, metric))
    return cells | {
        "never_99_percent": f"{100 * variant.never:.3f}",
        "minutes": f"{variant.minutes:.2f}",
        "settings": json.dumps(variant.settings),
    }


def _cells(name: str, estimate: Estimate) -> dict[str, str]:
    figures = zip(("", "_low", "_high"), estimate, strict=True)
    return {f"{name}{end}": "" if figure is None else f"{figure:.3f}" for end, figure in figures}


def write_table(found: Sequence[VariantScore], path: Path) -> None:
    """Write one row for each variant, the full one first."""
    write_rows(path, COLUMNS, (row(variant, found[0]) for variant in found))


def printed(found: Sequence[VariantScore]) -> Table:
    """Return the table for the terminal, the best first."""
    full = found[0]
    headings = ("variant", "seeds", "T90", "T99", "never", "T90 to full", "T99 to full", "minutes")
    table = Table(*headings, box=None, header_style="bold")
    for variant in sorted(found, key=lambda each: each.mean("t99").mean):
        apart = ["", ""] if variant is full else [_signed(variant.against(full, metric)) for metric in METRICS]
        means = [f"{variant.mean(metric).mean:.1f}" for metric in METRICS]
        rest = (f"{100 * variant.never:.1f} %", *apart, f"{variant.minutes:.1f}")
        table.add_row(variant.variant, str(len(variant.seeds)), *means, *rest)
    return table


def _signed(estimate: Estimate) -> str:
    bounds = "" if estimate.low is None or estimate.high is None else f" [{estimate.low:+.1f}, {estimate.high:+.1f}]"
    return f"{estimate.mean:+.1f}{bounds}"


def runs_of(
    learner: str,
    scenario_name: str,
    scenario: Scenario,
    *,
    patterns: Sequence[str],
    settings: Mapping[str, Any],
    seeds: int,
    out: Path,
) -> list[Training]:
    """Return the trainings of the matching variants and of the full one, ordered by seed.

    Raises:
        InputError: the learner has no variants, a pattern matches none, a setting is invalid, or a folder holds
            another training.

    """
    module = find_learner(learner)
    variants = _chosen(_declared(learner, module, scenario.team), patterns)
    shared = {**getattr(module, "ABLATION_SETTINGS", {}), **settings}
    runs = [
        Training(learner, scenario_name, name, seed, {**shared, **switches}, str(out / name / f"seed-{seed}"))
        for seed in range(1, seeds + 1)
        for name, switches in variants.items()
    ]
    for run in runs:
        run.finished()
    return runs


def _declared(learner: str, module: Any, team: int) -> dict[str, Mapping[str, Any]]:
    if not getattr(module, "ABLATIONS", None):
        raise InputError(f"expected a learner that declares ABLATIONS, as dddqn does, got {learner!r}, which does not")
    return {**module.ABLATIONS, **(getattr(module, "TEAM_ABLATIONS", {}) if team > 1 else {})}


def _chosen(variants: Mapping[str, Mapping[str, Any]], patterns: Sequence[str]) -> dict[str, Mapping[str, Any]]:
    full, *_ = variants
    wanted = {full, *matching(variants, patterns, "variant")}
    return {name: switches for name, switches in variants.items() if name in wanted}


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
    with writable(out, "--out"):
        out.mkdir(parents=True, exist_ok=True)
        try:
            failures = train_all(runs, jobs, lambda line: console.print(line, highlight=False, soft_wrap=True))
        except KeyboardInterrupt:
            console.print("interrupted; scoring the finished trainings, which another Ctrl-C skips")
            _conclude(runs, scenario, out, console, episodes, jobs, command)
            raise
        _conclude(runs, scenario, out, console, episodes, jobs, command)
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
