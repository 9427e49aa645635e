"""The ``scale`` command: train with more and less experience, width and maps, and compare."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.studies.many_trainings import Failure, Training, write_rows
from indoor_explorers.evaluation.studies.training import find_learner
from indoor_explorers.evaluation.studies.variants.scaling_drawing import write_figure
from indoor_explorers.evaluation.studies.variants.scoring import VariantScore
from indoor_explorers.evaluation.studies.variants.study import METRICS, StudyRequest, cells, run_study, trainings_of

COLUMNS = (
    *("axis", "level", "variant", "seeds"),
    *(f"{metric}{end}" for metric in METRICS for end in ("", "_low", "_high")),
    *("never_99_percent", "minutes", "settings"),
)

#: Names of variants by level, by axis; an infinite level is one without a limit.
Axes = Mapping[str, Mapping[float, str]]


def runs_of(request: StudyRequest) -> list[Training]:
    """Return the trainings of the variants that match the patterns, ordered by seed.

    Raises:
        InputError: the learner declares no such study, or :func:`trainings_of` does.

    """
    module = find_learner(request.learner)
    if not getattr(module, "SCALING", None):
        raise InputError(f"expected a learner that declares SCALING, as dddqn does, got {request.learner!r}")
    return trainings_of(request, module.SCALING)


def levels(axes: Axes, found: Sequence[VariantScore]) -> dict[str, dict[float, VariantScore]]:
    """Return the finished variants by level and axis; axes with none are left out."""
    scores = {each.variant: each for each in found}
    there = {
        axis: {level: scores[name] for level, name in named.items() if name in scores} for axis, named in axes.items()
    }
    return {axis: by_level for axis, by_level in there.items() if by_level}


def row(axis: str, level: float, variant: VariantScore) -> dict[str, Any]:
    """Return the row of one level of an axis."""
    found: dict[str, Any] = {"axis": axis, "level": level_text(level), "variant": variant.variant}
    found |= {"seeds": len(variant.seeds)}
    for metric in METRICS:
        found |= cells(metric, variant.mean(metric))
    return found | {
        "never_99_percent": f"{100 * variant.never:.3f}",
        "minutes": f"{variant.minutes:.2f}",
        "settings": json.dumps(variant.settings),
    }


def level_text(level: float) -> str:
    """Return a level as text: a whole number, or ``unlimited``."""
    return "unlimited" if math.isinf(level) else f"{level:.0f}"


def run_scaling(request: StudyRequest, console: Console) -> list[Failure]:
    """Train the variants of a learner's scaling study that match the patterns, and compare them on unseen maps.

    Writes ``scaling.csv`` and ``figures/scaling.{svg,png,pdf}`` beside what
    :func:`~indoor_explorers.evaluation.studies.variants.study.run_study` does. Returns the trainings that failed.

    Raises:
        InputError: there is no such learner, variant or setting, or ``out`` holds other trainings.

    """
    axes = getattr(find_learner(request.learner), "SCALING_AXES", {})
    return run_study(request, runs_of(request), console, partial(_conclude, axes, request.scenario.name, console))


def _conclude(axes: Axes, scenario: str, console: Console, found: Sequence[VariantScore], out: Path) -> None:
    """Write and print the results."""
    if not found:
        console.print("no training is finished yet")
        return
    there = levels(axes, found)
    rows = [row(axis, level, each) for axis, by_level in there.items() for level, each in by_level.items()]
    write_rows(out / "scaling.csv", COLUMNS, rows)
    figure = write_figure(there, scenario, out / "figures")
    console.print(printed(there))
    console.print(f"Table: {out / 'scaling.csv'}", highlight=False, soft_wrap=True)
    console.print(f"Figure: {figure}", highlight=False, soft_wrap=True)


def printed(there: Mapping[str, Mapping[float, VariantScore]]) -> Table:
    """Return the table for the terminal."""
    table = Table("axis", "level", "seeds", "T90", "T99", "never", "minutes", box=None, header_style="bold")
    for axis, by_level in there.items():
        for level, each in by_level.items():
            means = [f"{each.mean(metric).mean:.1f}" for metric in METRICS]
            rest = (f"{100 * each.never:.1f} %", f"{each.minutes:.1f}")
            table.add_row(axis, level_text(level), str(len(each.seeds)), *means, *rest)
    return table
