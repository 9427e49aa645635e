"""The metrics of an episode; their definitions are printed in the report.

Coverage at step t is the share of the denominator in the map of the team, of correct cells alone where sensors or poses
err. T_q is the first step with coverage >= q.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.evaluation.harness.episodes.steps import covered_columns

#: Coverage thresholds whose first step is reported.
LEVELS = {"t50": 0.50, "t90": 0.90, "t95": 0.95, "t98": 0.98, "t99": 0.99}


@dataclass(frozen=True)
class Measure:
    """Describes a metric."""

    title: str
    unit: str
    definition: str
    lower_is_better: bool = True


MEASURES: dict[str, Measure] = {
    "auc": Measure(
        "AUC", "", "area under the coverage curve over the budget, constant after the end, as a share of 1", False
    ),
    "auc_worst": Measure("AUC, worst UAV", "", "the same for the coverage of the UAV that knows least", False),
    "t99_worst": Measure(
        "T99, worst UAV", "steps", "first step at which the own map of every UAV has 99 %; if never, the budget"
    ),
    "auc_mean": Measure("AUC, mean UAV", "", "the same for the mean coverage of a UAV's own map", False),
    **{
        name: Measure(
            f"T{level:.0%}".rstrip("%"),
            "steps",
            f"first step with {level:.0%} coverage; an episode that never gets there counts as its budget",
        )
        for name, level in LEVELS.items()
    },
    "t99_to_bound": Measure(
        "T99 / bound",
        "",
        "T99 / a lower bound that holds for every team, whatever it knows: the largest of five bounds, by lidar range, "
        "sight, distance, a spanning tree of places that must be looked at, and a flow that newly shows every cell",
    ),
    "t99_to_reference": Measure(
        "T99 / reference",
        "",
        "T99 / T99 of the policy that knows the map, a good tour but no bound, on the same map, spawns and seed",
    ),
    "auc_base": Measure("AUC, home base", "", "the same as AUC for what the home base knows", False),
    "t90_base": Measure("T90, home base", "steps", "first step at which the home base knows 90%; if never, the budget"),
    "t99_base": Measure("T99, home base", "steps", "first step at which the home base knows 99%; if never, the budget"),
    "auc_seen": Measure("AUC, seen", "", "the same as AUC for what any UAV or the home base knows", False),
    "unreported": Measure("unreported", "", "coverage at the end that the home base does not know"),
    "done_step": Measure(
        "declared done", "steps", "first step at which all UAVs that flew would have ended the mission; they flew on"
    ),
    "done_coverage": Measure("coverage when done", "", "coverage at that step", False),
    "done_lost": Measure("lost by stopping", "", "coverage that was still gained after that step"),
    "done_saved": Measure("saved by stopping", "steps", "steps that were flown after it", False),
    "path_length": Measure("path length", "cells", "cells flown by all UAVs together"),
    "path_max": Measure("longest path", "cells", "cells flown by the UAV that flew farthest"),
    "path_max_m": Measure(
        "longest path, any angle",
        "m",
        "metres flown by the UAV that flew farthest, with straight lines for the staircases of its track wherever no "
        "obstacle is between; of maps of one level with a scale",
    ),
    "overlap": Measure("overlap", "", "(sum of cells each lidar saw - cells the team saw) / cells the team saw"),
    "balance": Measure("balance", "", "standard deviation over the UAVs of the share of cells each lidar saw"),
    "surface": Measure(
        "surface",
        "",
        "share of the obstacle voxels beside a counted free voxel that the team's map shows at the end; of maps of "
        "several levels",
        False,
    ),
    "collisions": Measure("collisions", "", "moves into an obstacle or off the map"),
    "blocked": Measure("blocked moves", "", "moves that a teammate blocked"),
    "stopped": Measure("stopped UAVs", "", "UAVs that a failure has stopped", True),
    "map_error": Measure(
        "map error", "", "share of the cells that the team's map shows at the end that it shows wrongly"
    ),
    "claimed": Measure("claimed coverage", "", "coverage at the end if the team's whole map were right", False),
    "pose_error": Measure(
        "pose error",
        "cells",
        "distance between where a UAV believes to be and where it is, mean over UAVs and steps",
    ),
    "longest_idle": Measure(
        "longest idle",
        "steps",
        "most steps in a row that a UAV stood still, blocked moves included, while its own map lacked free cells that "
        "it could reach",
    ),
    "longest_dither": Measure(
        "longest oscillation",
        "steps",
        "most steps in a row that each undid the one before (A-B-A-B), while the UAV's own map lacked free cells that "
        "it could reach",
    ),
    "idle_share": Measure(
        "idle share",
        "",
        "share of steps at which a UAV stood still, of those at which its own map lacked free cells it could reach",
    ),
    "messages_bytes": Measure(
        "messages",
        "bytes",
        "bytes sent by radio: 5 for a cell new to its receiver, 8 for a position, 8 for a number",
    ),
    "age_of_information": Measure(
        "age of information",
        "steps",
        "steps since a UAV last heard from a teammate, mean over pairs and steps; counts from the start if never",
    ),
    "latency_total_s": Measure("latency, all", "s", "time of all decisions of the team together, without compiling"),
    "latency_p50_us": Measure(
        "latency p50",
        "us",
        "median time of a decision, without compiling; where many are made at once, their time / their number",
    ),
    "latency_p99_us": Measure("latency p99", "us", "99th percentile of the same"),
}

#: The times to what a home base knows, and all measures of episodes with one.
TIMES_OF_BASE = ("t90_base", "t99_base")
#: Times that only some episodes have.
OTHER_TIMES = (*TIMES_OF_BASE, "t99_worst")
#: All times: one that was never reached is None.
TIMES = (*LEVELS, *OTHER_TIMES)
OF_BASE = ("auc_base", *TIMES_OF_BASE, "auc_seen", "unreported")
#: The measures of wasted steps in a row.
WASTED = ("longest_idle", "longest_dither")
#: Metrics that depend on the machine: they differ between runs.
OF_THE_MACHINE = ("latency_total_s", "latency_p50_us", "latency_p99_us")


def tolerated_steps(metric: str, team: int) -> int:
    """Return how many steps in a row of one of :data:`WASTED` are normal in an episode of ``team`` UAVs.

    In corridors one cell wide a UAV may have to wait for those in front of it, about six steps for each. Flying to and
    fro for more than six steps is never necessary.
    """
    return 6 * team if metric == "longest_idle" else 6


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
    flown = float(np.trapezoid(curve[: budget + 1]))
    return (flown + float(curve[-1]) * max(0, budget + 1 - len(curve))) / budget


def team_metrics(covered: NDArray[np.integer], team: int, reachable: int, budget: int) -> dict[str, float | None]:
    """Return the metrics of the covered cells of an episode.

    Args:
        covered: see :attr:`~indoor_explorers.evaluation.harness.episodes.steps.Steps.covered`.
        team: UAVs.
        reachable: the denominator of coverage, in cells.
        budget: steps.

    """
    columns, base, _ = covered_columns(team)
    own = covered[:, columns]
    return {
        **curve_metrics(covered[:, 0] / reachable, budget),
        "auc_worst": area_under_curve(own.min(axis=1) / reachable, budget),
        "t99_worst": first_step(own.min(axis=1) / reachable, LEVELS["t99"]),
        "auc_mean": area_under_curve(own.mean(axis=1) / reachable, budget),
        **_base_metrics(covered[:, base:] / reachable, budget),
    }


def stop_metrics(curve: NDArray[np.floating], done: int) -> dict[str, float | None]:
    """Return the cost and the saving of ending a mission at step ``done``, from its (S + 1,) coverage curve."""
    reached = float(curve[done])
    return {
        "done_step": float(done),
        "done_coverage": reached,
        "done_lost": float(curve[-1]) - reached,
        "done_saved": float(len(curve) - 1 - done),
    }


def _base_metrics(curves: NDArray[np.floating], budget: int) -> dict[str, float | None]:
    """Return the metrics of (S + 1, 2) coverage by the base's map and by all maps together; none without a base."""
    if curves.shape[1] == 0:
        return {}
    base, seen = curves.T
    return {
        "auc_base": area_under_curve(base, budget),
        "t90_base": first_step(base, LEVELS["t90"]),
        "t99_base": first_step(base, LEVELS["t99"]),
        "auc_seen": area_under_curve(seen, budget),
        "unreported": float(seen[-1] - base[-1]),
    }


def curve_metrics(curve: NDArray[np.floating], budget: int) -> dict[str, float | None]:
    """Return the metrics of a team coverage curve; T_q is None when it was never reached."""
    return {"auc": area_under_curve(curve, budget), **{name: first_step(curve, q) for name, q in LEVELS.items()}}
