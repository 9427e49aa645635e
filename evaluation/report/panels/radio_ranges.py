"""Plots of times, AUC, bytes sent and overlap against the range of the radio, a line for each policy."""

from __future__ import annotations

import math
from typing import NamedTuple

from indoor_explorers.evaluation.report.analysis.sweeps import RadioSweep
from indoor_explorers.evaluation.report.panels.plot_data import Plot, PlotAxis, PlotSeries, bounds
from indoor_explorers.evaluation.report.style.formatting import fixed, with_interval
from indoor_explorers.evaluation.report.style.palette import PolicyStyle, Styles
from indoor_explorers.evaluation.results.coverage_threshold import CoverageThreshold
from indoor_explorers.evaluation.results.results import Results
from indoor_explorers.evaluation.statistics import FEWEST, Estimate, bootstrap_mean

#: Offset between policies as a share of the axis, so that their intervals do not hide each other.
APART = 0.012
#: Ratio of highest to lowest value from which an axis is logarithmic.
WIDE = 4.0


class Quantity(NamedTuple):
    """The quantity that a plot shows."""

    metric: str
    title: str
    unit: str
    divisor: float
    decimals: int

    @property
    def heading(self) -> str:
        """The name with its unit."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title


#: Quantities that are shown besides times.
OTHERS = (
    Quantity("auc", "AUC", "", 1, 3),
    Quantity("messages_bytes", "messages", "kB", 1000, 2),
    Quantity("overlap", "overlap", "", 1, 2),
)


def range_plots(results: Results, sweep: RadioSweep, styles: Styles) -> list[Plot]:
    """Return a plot for each quantity, of the policies flown at two ranges or more; empty without any."""
    policies = [
        policy for policy in results.policies if sum((name, policy) in results.groups for name in sweep.scenarios) > 1
    ]
    times = [
        Quantity(key, CoverageThreshold(key).title, "steps", 1, 1) for key in results.level(sweep.scenarios[0]).times
    ]
    shown = (*times, *OTHERS) if policies else ()
    return [_plot(results, sweep, quantity, policies, styles) for quantity in shown]


def _plot(results: Results, sweep: RadioSweep, quantity: Quantity, policies: list[str], styles: Styles) -> Plot:
    places = _places(sweep.reaches)
    span = max(places.values()) or 1.0
    series = [
        _series(results, sweep, quantity, policy, styles[policy], (k - (len(policies) - 1) / 2) * APART * span)
        for k, policy in enumerate(policies)
    ]
    ends = [end for each in series for end in (*each.y, *(each.low or []), *(each.high or []))]
    ends += [value for each in series for _, value in each.dots or []]
    ticks = tuple((place, _named(far)) for far, place in places.items())
    return Plot(
        title=quantity.heading,
        label=f"{quantity.heading} against the range of the radio",
        x=PlotAxis(title="radio range [cells]", low=-0.07 * span, high=1.07 * span, ticks=ticks),
        y=_upright(ends),
        series=series,
    )


def _upright(ends: list[float]) -> PlotAxis:
    """Return the y axis around all that is drawn: logarithmic where it spans a factor of four or more."""
    low, high = min(ends), max(ends)
    if low > 0 and high >= WIDE * low:
        return PlotAxis(title="", low=low / 1.15, high=high * 1.15, log=True)
    margin = 0.08 * ((high - low) or 1.0)
    return PlotAxis(title="", low=max(0.0, low - margin), high=high + margin)


def _places(reaches: tuple[float, ...]) -> dict[float, float]:
    """Return where on the axis each range is drawn: an unlimited one a quarter beyond the longest, or at 1."""
    longest = max(far for far in reaches if far < math.inf)
    return {far: far if far < math.inf else 1.25 * longest or 1.0 for far in reaches}


def _named(far: float) -> str:
    return {0.0: "none", math.inf: "unlimited"}.get(far, f"{far:g}")


def _series(
    results: Results, sweep: RadioSweep, quantity: Quantity, policy: str, style: PolicyStyle, offset: float
) -> PlotSeries:
    places = _places(sweep.reaches)
    pairs = zip(sweep.scenarios, sweep.reaches, strict=True)
    flown = [(results.groups[name, policy], far) for name, far in pairs if (name, policy) in results.groups]
    samples = [results.values(r[0].task.scenario, policy, quantity.metric) / quantity.divisor for r, _ in flown]
    maps = [results.maps(records[0].task.scenario, policy) for records, _ in flown]
    estimates = [bootstrap_mean(values, maps=here) for values, here in zip(samples, maps, strict=True)]
    low, high = bounds(estimates)
    x = [places[far] + offset for _, far in flown]
    few = [
        (at, each) for at, values in zip(x, samples, strict=True) if len(values) < FEWEST for each in values.tolist()
    ]
    return PlotSeries(
        name=policy,
        style=style,
        x=x,
        y=[each.mean for each in estimates],
        low=low,
        high=high,
        dots=few or None,
        text=[_text(far, estimate, quantity) for (_, far), estimate in zip(flown, estimates, strict=True)],
    )


def _text(far: float, estimate: Estimate, quantity: Quantity) -> str:
    shown = with_interval(estimate, quantity.decimals) if estimate.mean else fixed(0.0, 0)
    return f"radio {_named(far)}: {quantity.title} {shown} {quantity.unit}".strip()
