"""What is measured in one episode; definitions are printed beside the figures.

Coverage at step t is the share of the denominator that the team knows together. T_q is the first step
with coverage >= q.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

#: Coverage levels whose first step is reported.
LEVELS = {"t50": 0.50, "t90": 0.90, "t95": 0.95, "t98": 0.98, "t99": 0.99}


@dataclass(frozen=True)
class Measure:
    """Say what a metric is."""

    title: str
    unit: str
    definition: str
    lower_is_better: bool = True


MEASURES: dict[str, Measure] = {
    "auc": Measure(
        "AUC", "", "area under the coverage curve over the budget, constant after the end, as a share of 1", False
    ),
    **{
        name: Measure(
            f"T{level:.0%}".rstrip("%"),
            "steps",
            f"first step with {level:.0%} coverage; an episode that never gets there counts as its budget",
        )
        for name, level in LEVELS.items()
    },
    "path_length": Measure("path length", "cells", "cells flown by all UAVs together"),
    "path_max": Measure("longest path", "cells", "cells flown by the UAV that flew most"),
    "overlap": Measure("overlap", "", "(sum of cells each lidar saw - cells the team saw) / cells the team saw"),
    "balance": Measure("balance", "", "standard deviation over the UAVs of the share each lidar saw itself"),
    "collisions": Measure("collisions", "", "moves into an obstacle or off the map"),
    "blocked": Measure("blocked moves", "", "moves that a teammate was in the way of"),
    "messages_bytes": Measure(
        "messages", "bytes", "bytes sent by radio: 5 a cell that was new to its receiver, 8 a position, 8 a number"
    ),
    "latency_p50_us": Measure("latency p50", "us", "median time of a decision; in a batch, its time / its size"),
    "latency_p99_us": Measure("latency p99", "us", "99th percentile of the same"),
}

#: Metrics that measure the machine and not the flight: they differ between runs.
OF_THE_MACHINE = ("latency_p50_us", "latency_p99_us")


def first_step(curve: NDArray[np.floating], level: float) -> int | None:
    """Return the first index of ``curve`` (T + 1,) at or above ``level``, None when there is none."""
    reached = np.flatnonzero(curve >= level - 1e-12)
    return int(reached[0]) if len(reached) else None


def extended(curve: NDArray[np.floating], length: int) -> NDArray[np.float64]:
    """Return a curve cut or continued at its last value to ``length`` entries."""
    out = np.full(length, curve[-1], np.float64)
    out[: min(length, len(curve))] = curve[:length]
    return out


def area_under_curve(curve: NDArray[np.floating], budget: int) -> float:
    """Return the trapezoid area of coverage over 0..budget as a share of the whole rectangle."""
    return float(np.trapezoid(extended(curve, budget + 1)) / budget)


def curve_metrics(curve: NDArray[np.floating], budget: int) -> dict[str, float | None]:
    """Return the metrics of a team coverage curve; T_q is None when it was never reached."""
    return {"auc": area_under_curve(curve, budget), **{name: first_step(curve, q) for name, q in LEVELS.items()}}
