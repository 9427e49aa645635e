"""The table of an ablation, one row for each variant, as a file and for the terminal."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.table import Table

from indoor_explorers.env.files import written_whole
from indoor_explorers.evaluation.statistics import Estimate
from indoor_explorers.evaluation.studies.ablation.scoring import VariantScore

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
    with written_whole(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, COLUMNS, restval="", lineterminator="\n")
        table.writeheader()
        table.writerows(row(variant, found[0]) for variant in found)


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
