"""Prints figures as they are measured: grouped, aligned, in readable units."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rich.console import Console

from indoor_explorers.evaluation.studies.bench.figure import REPEATS, Benchmark, Figure
from indoor_explorers.evaluation.studies.bench.worlds import cores

NAME_WIDTH = 44
#: Larger units of a unit: from which value on, divisor, name.
LARGER = {
    "us": ((1e6, 1e6, "s"), (1e3, 1e3, "ms")),
    "bytes": ((2**20, 2**20, "MiB"), (2**10, 2**10, "KiB")),
}
PREFIXES = ((1e6, 1e6, "M "), (1e4, 1e3, "k "))


def measured(measures: Iterable[Benchmark], console: Console) -> Iterator[Figure]:
    """Measure, print and yield one figure after the other."""
    group = None
    for measure in measures:
        if measure.group != group:
            group = measure.group
            console.print(group, style="bold", highlight=False)
        figure = Figure(measure.name, measure.take(), measure.unit)
        console.print(line_of(figure), highlight=False, markup=False, soft_wrap=True)
        yield figure
    many = f"{cores()} core{'s' if cores() > 1 else ''}"
    console.print(
        f"Speeds are medians of {REPEATS} repetitions on {many}; compare only figures of one run.",
        style="dim",
        highlight=False,
        soft_wrap=True,
    )


def line_of(figure: Figure) -> str:
    """Return the line of a figure."""
    number, unit = human(figure.value, figure.unit)
    return f"  {figure.name:<{NAME_WIDTH}} {number:>8} {unit}"


def human(value: float, unit: str) -> tuple[str, str]:
    """Return a value with three digits and a suitable unit: 5,320,000 agent-steps/s is 5.32 M agent-steps/s."""
    for least, by, name in LARGER.get(unit, tuple((least, by, prefix + unit) for least, by, prefix in PREFIXES)):
        if value >= least:
            return three_digits(value / by), name
    return three_digits(value), unit


def three_digits(value: float) -> str:
    """Return a number with three significant digits, whole from 100 on."""
    digits = 0 if value >= 99.95 else 1 if value >= 9.995 else 2
    return f"{value:,.{digits}f}"
