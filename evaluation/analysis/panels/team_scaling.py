"""Plots of speed-up and parallel efficiency against the number of UAVs, a line for each policy."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.evaluation.analysis.panels.plot_data import Guide, Plot, PlotAxis, PlotSeries, bounds
from indoor_explorers.evaluation.analysis.panels.sweep_plots import APART
from indoor_explorers.evaluation.analysis.sweeps import TeamScaling
from indoor_explorers.evaluation.drawing.formatting import percent_with_interval, with_interval
from indoor_explorers.evaluation.drawing.palette import Styles
from indoor_explorers.evaluation.harness.results.coverage_threshold import CoverageThreshold
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.statistics import FEWEST, Estimate, ratio_of_means


class SpeedUp(NamedTuple):
    """How much faster a team is than one UAV."""

    team: int
    speedup: Estimate
    """Mean T(1) / mean T(N) over the common maps and seeds."""
    each: list[float]
    """The ratio on every task if these are too few for an interval."""
    censored: bool
    """Whether an episode never reached the threshold and counts as its budget."""

    def per_uav(self) -> SpeedUp:
        """Return the speed-up divided by the number of UAVs: the parallel efficiency."""
        mean, low, high = self.speedup
        share = Estimate(mean / self.team, low and low / self.team, high and high / self.team)
        return self._replace(speedup=share, each=[value / self.team for value in self.each])


def speed_ups(results: Results, scaling: TeamScaling, policy: str, metric: str) -> list[SpeedUp]:
    """Return a policy's speed-ups by team, one UAV first; teams that never reached the threshold are left out."""
    solo = _times(results, scaling.scenarios[0], policy, metric)
    maps = _maps(results, scaling.scenarios[0], policy)
    found = []
    for name, team in zip(scaling.scenarios, scaling.teams, strict=True):
        times = _times(results, name, policy, metric)
        common = sorted(solo.keys() & times.keys())
        alone, together = (np.array([source[key] for key in common]).reshape(-1, 2) for source in (solo, times))
        if len(common) and alone[:, 1].any() and together[:, 1].any():
            found.append(_gain(team, alone, together, [maps[key] for key in common]))
    return found if len(found) > 1 else []


def _times(results: Results, scenario: str, policy: str, metric: str) -> dict[tuple[int, int], tuple[float, bool]]:
    """Return (steps, reached) by map and seed; a threshold reached at the start counts as one step."""
    if (scenario, policy) not in results.groups:
        return {}
    values = np.maximum(results.values(scenario, policy, metric), 1.0).tolist()
    records = results.groups[scenario, policy]
    return {
        (record.task.map_index, record.task.seed): (value, record.metrics.get(metric) is not None)
        for record, value in zip(records, values, strict=True)
    }


def _maps(results: Results, scenario: str, policy: str) -> dict[tuple[int, int], str]:
    """Return which map each episode was flown on, by map and seed; equal maps have equal labels."""
    if (scenario, policy) not in results.groups:
        return {}
    tasks = [record.task for record in results.groups[scenario, policy]]
    labels = results.maps(scenario, policy).tolist()
    return {(task.map_index, task.seed): label for task, label in zip(tasks, labels, strict=True)}


def _gain(team: int, alone: NDArray[np.float64], together: NDArray[np.float64], maps: list[str]) -> SpeedUp:
    """Compare a team with one UAV by (E, 2) arrays: steps, and 1 where the threshold was reached."""
    censored = not bool(alone[:, 1].all() and together[:, 1].all())
    if team == 1:
        return SpeedUp(1, Estimate(1.0, None, None), [], censored)
    ratios = (alone[:, 0] / together[:, 0]).tolist() if len(maps) < FEWEST else []
    return SpeedUp(team, ratio_of_means(alone[:, 0], together[:, 0], maps=maps), ratios, censored)


def scaling_plots(results: Results, scaling: TeamScaling, styles: Styles) -> list[Plot]:
    """Return speed-ups to 90 % and to the threshold, and efficiency to the threshold; empty without common policies."""
    plots, judging = [], results.level(scaling.scenarios[0])
    for metric in judging.times:
        level = CoverageThreshold(metric).percent
        found = {policy: speed_ups(results, scaling, policy, metric) for policy in results.policies}
        found = {policy: each for policy, each in found.items() if each}
        if found:
            plots.append(_speedup_plot(found, scaling, level, styles))
        if found and metric == judging.key:
            plots.append(_efficiency_plot(found, scaling, level, styles))
    return plots


def _speedup_plot(found: Mapping[str, list[SpeedUp]], scaling: TeamScaling, level: str, styles: Styles) -> Plot:
    most = scaling.teams[-1]
    series = _series(found, styles, _speedup_text)
    return Plot(
        title=f"Speed-up to {level}",
        label=f"Speed-up to {level} coverage against the number of UAVs",
        x=_teams(scaling),
        y=PlotAxis(title="T(1) / T(N)", low=0.0, high=max(1.5, 1.12 * _top(series))),
        series=series,
        guides=[Guide(name="ideal", x=[1.0, float(most)], y=[1.0, float(most)])],
    )


def _efficiency_plot(found: Mapping[str, list[SpeedUp]], scaling: TeamScaling, level: str, styles: Styles) -> Plot:
    shares = {policy: [each.per_uav() for each in found[policy]] for policy in found}
    series = _series(shares, styles, _efficiency_text)
    return Plot(
        title=f"Efficiency to {level}",
        label=f"Parallel efficiency to {level} coverage against the number of UAVs",
        x=_teams(scaling),
        y=PlotAxis(title="T(1) / (N T(N))", low=0.0, high=max(1.08, 1.05 * _top(series)), share=True),
        series=series,
        guides=[Guide(name="ideal", x=[1.0, float(scaling.teams[-1])], y=[1.0, 1.0])],
    )


def _teams(scaling: TeamScaling) -> PlotAxis:
    most = scaling.teams[-1]
    ticks = tuple((float(team), str(team)) for team in scaling.teams)
    return PlotAxis(title="UAVs", low=1 - 0.06 * (most - 1), high=most + 0.06 * (most - 1), ticks=ticks)


def _top(series: list[PlotSeries]) -> float:
    dots = [value for each in series for _, value in each.dots or []]
    return max(end for each in series for end in (*each.y, *(each.high or []), *dots, 0.0))


def _series(found: Mapping[str, list[SpeedUp]], styles: Styles, text_of: Callable[[SpeedUp], str]) -> list[PlotSeries]:
    """Return the line of each policy, with an offset so that intervals do not hide each other."""
    span = max(each.team for gains_of in found.values() for each in gains_of) - 1
    lines = []
    for place, (policy, of_policy) in enumerate(found.items()):
        beside = (place - (len(found) - 1) / 2) * APART * span
        low, high = bounds([each.speedup for each in of_policy])
        x = [each.team + (beside if each.team > 1 else 0.0) for each in of_policy]
        lines.append(
            PlotSeries(
                name=policy,
                style=styles[policy],
                x=x,
                y=[each.speedup.mean for each in of_policy],
                low=low,
                high=high,
                dots=[(at, value) for at, each in zip(x, of_policy, strict=True) for value in each.each] or None,
                hollow=[each.censored for each in of_policy],
                text=[text_of(each) for each in of_policy],
            )
        )
    return lines


def _speedup_text(gain: SpeedUp) -> str:
    return f"{gain.team} UAVs: {with_interval(gain.speedup, 2)} times as fast"


def _efficiency_text(gain: SpeedUp) -> str:
    return f"{gain.team} UAVs: {percent_with_interval(gain.speedup)}"
