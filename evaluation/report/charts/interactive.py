"""The data of the interactive charts, small enough to embed: coverage curves with bands, and times to thresholds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.coverage_axes import CoverageAxis, axes_of, coverage_along
from indoor_explorers.evaluation.analysis.outliers import near_groups
from indoor_explorers.evaluation.drawing.palette import PolicyStyle, Styles, crowded
from indoor_explorers.evaluation.harness.episodes.metrics import LEVELS, MEASURES
from indoor_explorers.evaluation.report.packing import shares
from indoor_explorers.evaluation.statistics import FEWEST, Band, curve_bands, ecdf_of_times

#: Whose coverage a chart can show, with the words for it.
WHO = {"team": "Team", "worst": "Worst UAV", "mean": "Mean UAV", "base": "Home base", "seen": "Any UAV or base"}
#: Times that are drawn if they are not above the goal of the scenario; the first one is shown at first.
TIMES = ("t99", "t95", "t90")
#: Share of successful episodes from which a policy counts for the range of steps that is shown at first.
MOSTLY = 0.9
#: Limit of points of a distribution of times.
CORNERS = 400


def _about(comparison: Comparison, policy: str, style: PolicyStyle) -> dict[str, Any]:
    about = {"name": policy, **style._asdict(), "pattern": style.pattern}
    return about | {"privileged": comparison.privileged(policy)}


def chart_data(comparison: Comparison, styles: Styles, points: int = 360) -> dict[str, Any]:
    """Return the coverage chart of a scenario as JSON data."""
    axes = axes_of(comparison, points)
    who = coverage_scopes(comparison.results.scenarios[comparison.scenario])
    return {
        "axes": [_axis_data(axis) for axis in axes],
        "who": who,
        "bands": "hidden" if crowded(len(comparison.groups)) else "shown",
        "policies": [
            _about(comparison, policy, styles[policy]) | {"curves": _curves(comparison, policy, axes, who)}
            for policy in comparison.groups
        ],
    }


def coverage_scopes(settings: Mapping[str, Any]) -> list[str]:
    """Return whose coverage the chart of a scenario can show; where only reports count, the team's is the base's."""
    base = settings.get("base") or {"at": "none"}
    of_base = [] if base["at"] == "none" else ["seen"] if base["must_return"] else ["base"]
    return ["team", *(["worst", "mean"] if settings["team"] > 1 else []), *of_base]


def _axis_data(axis: CoverageAxis) -> dict[str, Any]:
    amounts: list[float] = axis.amounts.tolist() if axis.log else axis.amounts.astype(np.int64).tolist()
    about = {"key": axis.key, "title": axis.title, "unit": axis.unit, "log": axis.log, "focus": axis.focus}
    return about | {"amounts": amounts}


def _curves(
    comparison: Comparison, policy: str, axes: Sequence[CoverageAxis], who: Sequence[str]
) -> dict[str, dict[str, Any]]:
    """Return the curves of a policy by axis and by whose coverage they are."""
    along = coverage_along(comparison.groups[policy], {axis.key: axis.amounts for axis in axes}, who)
    bands = curve_bands(list(along.values()), maps=comparison.maps(policy))
    found = {key: _curve(curves, band) for (key, curves), band in zip(along.items(), bands, strict=True)}
    return {axis.key: {each: found[axis.key, each] for each in who} for axis in axes}


def _curve(curves: NDArray[np.float64], band: Band) -> dict[str, Any]:
    if len(curves) < FEWEST:
        return {"mean": shares(band.mean), "each": [shares(curve) for curve in curves]}
    return {"mean": shares(band.mean), "low": shares(band.low), "high": shares(band.high)}


def times_data(comparison: Comparison, styles: Styles) -> dict[str, Any]:
    """Return, for every threshold and policy, the share of episodes that reached it by each step, as JSON data."""
    records = comparison.records
    budget = max(record.budget for record in records)
    times = levels_drawn(comparison)
    return {
        "levels": [{"key": name, "title": MEASURES[name].title, "level": LEVELS[name]} for name in times],
        "budget": budget,
        "focus": _last_time(comparison, budget),
        "policies": [
            _about(comparison, policy, styles[policy])
            | {"episodes": len(group), "times": {name: _times(comparison, policy, name, budget) for name in times}}
            for policy, group in comparison.groups.items()
        ],
    }


def levels_drawn(comparison: Comparison) -> list[str]:
    """Return the times that the page shows of a scenario, that of its threshold first."""
    asked = [name for name in TIMES if comparison.results.applies_to(comparison.scenario, name)]
    return asked or [comparison.level.key]


def _last_time(comparison: Comparison, budget: int) -> int:
    """Return the last step at which an episode of a mostly successful policy reached the threshold, else the budget."""
    groups, key = near_groups(comparison).items(), comparison.level.key
    mostly = [group for policy, group in groups if comparison.reached(policy) >= MOSTLY]
    times = [late for group in mostly for record in group if (late := record.metrics.get(key)) is not None]
    return min(budget, int(max(times, default=budget) * 1.05) + 1)


def _times(comparison: Comparison, policy: str, level: str, budget: int) -> dict[str, list[float]]:
    steps, share = ecdf_of_times([record.metrics.get(level) for record in comparison.groups[policy]], budget)
    kept = _thinned(len(steps))
    return {"steps": steps[kept].astype(np.int64).tolist(), "share": share[kept].round(4).tolist()}


def _thinned(count: int) -> NDArray[np.int64]:
    """Return which of ``count`` points are kept; the first and the last always are."""
    return np.unique(np.linspace(0, count - 1, min(count, CORNERS)).round()).astype(np.int64)
