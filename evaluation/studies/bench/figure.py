"""Figures, how they are timed, and how they are written."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from indoor_explorers.env import InputError
from indoor_explorers.env.files import written_whole

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
    try:
        with written_whole(path) as partial:
            partial.write_text(json.dumps([figure._asdict() for figure in measured], indent=1) + "\n")
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}; choose another --json") from error
