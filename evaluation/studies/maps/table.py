"""The terminal's table of a comparison of maps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from rich import box
from rich.table import Table

from indoor_explorers.env.maps.statistics import Statistic
from indoor_explorers.evaluation.studies.maps.comparison import COMPARED, MapSet, Sample, distances

#: The quantiles that are shown of the given maps.
SHOWN = (0.1, 0.5, 0.9)


def comparison_table(given: MapSet, others: Sequence[MapSet]) -> Table:
    """Return a line for each statistic: its values on the given maps, and how far each of the other sets is away."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("statistic", no_wrap=True)
    table.add_column(f"{given.title}: 10, 50, 90 %", justify="right", no_wrap=True)
    for other in others:
        table.add_column(other.title, justify="right")
    found = [{kind.name: far for kind, far in distances(given, other)} for other in others]
    for kind in COMPARED:
        values = _values(kind, given.samples.get(kind.name))
        table.add_row(kind.name, values, *(_figure(far.get(kind.name)) for far in found))
    table.add_row("mean", "", *(_figure(float(np.mean(list(far.values()))) if far else None) for far in found))
    return table


def _values(kind: Statistic, sample: Sample | None) -> str:
    if sample is None:
        return ""
    shown = sample.quantiles(SHOWN)
    return ", ".join(f"{value:.0f}" if kind.logarithmic else f"{value:.2f}" for value in _unscaled(kind, shown))


def _unscaled(kind: Statistic, values: np.ndarray) -> list[float]:
    return [float(value) for value in (np.exp(values) if kind.logarithmic else values)]


def _figure(value: float | None) -> str:
    return "" if value is None else f"{value:.2f}"
