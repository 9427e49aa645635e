"""Figures: timed, printed as they are measured in readable units, and written as JSON."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from rich.console import Console

from indoor_explorers.env.files import writable, written_whole

#: Repetitions of which the median is taken, after a warm-up.
REPEATS = 5


class Figure(NamedTuple):
    """One measured figure."""

    name: str
    value: float
    unit: str


class Benchmark(NamedTuple):
    """One figure to be measured; ``take`` measures it, which takes seconds to minutes."""

    group: str
    name: str
    unit: str
    take: Callable[[], float]


def cores() -> int:
    """Return the number of cores."""
    return os.cpu_count() or 1


def median_of(measure: Callable[[], float], repeats: int = REPEATS) -> float:
    """Return the median of ``repeats`` measurements, after a warm-up."""
    measure()
    return float(np.median([measure() for _ in range(repeats)]))


def seconds_of(work: Callable[[], object]) -> float:
    """Return the seconds that ``work`` takes."""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def write_json(measured: Sequence[Figure], path: Path) -> None:
    """Write figures as a list of objects with name, value and unit."""
    with writable(path, "--json"), written_whole(path) as partial:
        partial.write_text(json.dumps([figure._asdict() for figure in measured], indent=1) + "\n")


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
