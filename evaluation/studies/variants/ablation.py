"""The ``ablate`` command: train the missing variants, score the finished ones, write the table and the figure."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.statistics import Estimate
from indoor_explorers.evaluation.studies.many_trainings import Failure, Training, write_rows
from indoor_explorers.evaluation.studies.training import find_learner
from indoor_explorers.evaluation.studies.variants.ablation_drawing import write_figure
from indoor_explorers.evaluation.studies.variants.scoring import VariantScore
from indoor_explorers.evaluation.studies.variants.study import (
    METRICS,
    StudyRequest,
    Variants,
    cells,
    run_study,
    trainings_of,
)

COLUMNS = (
    *("variant", "seeds"),
    *(f"{metric}{end}" for metric in METRICS for end in ("", "_low", "_high")),
    "never_99_percent",
    *(f"{metric}_to_full{end}" for metric in METRICS for end in ("", "_low", "_high")),
    *("minutes", "settings"),
)


def row(variant: VariantScore, full: VariantScore) -> dict[str, Any]:
    """Return the row of a variant; for the full one, differences are empty."""
    found: dict[str, Any] = {"variant": variant.variant, "seeds": len(variant.seeds)}
    for metric in METRICS:
        found |= cells(metric, variant.mean(metric))
        if variant is not full:
            found |= cells(f"{metric}_to_full", variant.against(full, metric))
    return found | {
        "never_99_percent": f"{100 * variant.never:.3f}",
        "minutes": f"{variant.minutes:.2f}",
        "settings": json.dumps(variant.settings),
    }


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


def runs_of(request: StudyRequest) -> list[Training]:
    """Return the trainings of the matching variants and of the full one, ordered by seed.

    Raises:
        InputError: the learner has no variants, or :func:`trainings_of` does.

    """
    module = find_learner(request.learner)
    variants = _declared(request, module)
    shared = {**getattr(module, "ABLATION_SETTINGS", {}), **request.settings}
    full, *_ = variants
    return trainings_of(replace(request, settings=shared), variants, always=[full])


def _declared(request: StudyRequest, module: Any) -> Variants:
    if not getattr(module, "ABLATIONS", None):
        raise InputError(
            f"expected a learner that declares ABLATIONS, as dddqn does, got {request.learner!r}, which does not"
        )
    return {**module.ABLATIONS, **(getattr(module, "TEAM_ABLATIONS", {}) if request.scenario.team > 1 else {})}


def run_ablation(request: StudyRequest, console: Console) -> list[Failure]:
    """Train the variants of a learner that match the patterns, and the full one, and compare them on unseen maps.

    Writes ``ablation.csv`` and ``figures/ablation.{svg,png,pdf}`` beside what
    :func:`~indoor_explorers.evaluation.studies.variants.study.run_study` does. Returns the trainings that failed.

    Raises:
        InputError: there is no such learner, variant or setting, or ``out`` holds other trainings.

    """
    runs = runs_of(request)
    return run_study(request, runs, console, partial(_conclude, runs[0].variant, request.scenario.name, console))


def _conclude(full: str, scenario: str, console: Console, found: Sequence[VariantScore], out: Path) -> None:
    """Write and print the results."""
    if not found or found[0].variant != full:
        console.print(f"no training of {full!r}, which all others are compared with, is finished yet")
        return
    write_table(found, out / "ablation.csv")
    figure = write_figure(found, scenario, out / "figures")
    console.print(printed(found))
    console.print(f"Table: {out / 'ablation.csv'}", highlight=False, soft_wrap=True)
    console.print(f"Figure: {figure}", highlight=False, soft_wrap=True)
