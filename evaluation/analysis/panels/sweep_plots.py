"""Plots of times, AUC and other quantities against the range of the radio or another setting, a line a policy."""

from __future__ import annotations

import math
from collections.abc import Sequence, Set
from typing import NamedTuple

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.outliers import far_behind
from indoor_explorers.evaluation.analysis.panels.plot_data import Plot, PlotAxis, PlotSeries, bounds
from indoor_explorers.evaluation.analysis.sweeps import RadioSweep, SettingSweep
from indoor_explorers.evaluation.drawing.formatting import fixed, with_interval
from indoor_explorers.evaluation.drawing.palette import PolicyStyle, Styles
from indoor_explorers.evaluation.harness.results.coverage_threshold import CoverageThreshold
from indoor_explorers.evaluation.harness.results.results import Results
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


#: Quantities that are shown against the range of the radio besides times.
OTHERS = (
    Quantity("auc", "AUC", "", 1, 3),
    Quantity("messages_bytes", "messages", "kB", 1000, 2),
    Quantity("overlap", "overlap", "", 1, 2),
)


class SweptAxis(NamedTuple):
    """The values that a sweep's scenarios have, along x."""

    title: str
    word: str
    """Name of the setting in a sentence."""
    scenarios: tuple[str, ...]
    places: tuple[float, ...]
    """Place of each scenario."""
    names: tuple[str, ...]
    """Value of each scenario as text."""
    low: float
    """Where the axis begins, but for a margin."""

    @property
    def span(self) -> float:
        """Its length without margins."""
        return (max(self.places) - self.low) or 1.0


def range_plots(results: Results, sweep: RadioSweep, styles: Styles) -> list[Plot]:
    """Return a plot for each quantity, of the policies flown at two ranges or more; empty without any."""
    names = tuple({0.0: "none", math.inf: "unlimited"}.get(far, f"{far:g}") for far in sweep.reaches)
    places = _places(sweep.reaches)
    axis = SweptAxis("radio range [cells]", "radio", sweep.scenarios, places, names, 0.0)
    return _plots(results, axis, OTHERS, "the range of the radio", styles)


def setting_plots(results: Results, sweep: SettingSweep, styles: Styles) -> list[Plot]:
    """Return a plot for each time, of the policies flown with two values or more; empty without any."""
    names = tuple(f"{value:g}" for value in sweep.values)
    word = sweep.setting.partition(" [")[0]
    axis = SweptAxis(sweep.setting, word, sweep.scenarios, sweep.values, names, min(sweep.values))
    return _plots(results, axis, (), word, styles)


def _plots(results: Results, axis: SweptAxis, others: Sequence[Quantity], about: str, styles: Styles) -> list[Plot]:
    policies = [
        policy for policy in results.policies if sum((name, policy) in results.groups for name in axis.scenarios) > 1
    ]
    times = [
        Quantity(key, CoverageThreshold(key).title, "steps", 1, 1) for key in results.level(axis.scenarios[0]).times
    ]
    shown = (*times, *others) if policies else ()
    far = _far(results, axis)
    return [_plot(results, axis, quantity, about, {name: styles[name] for name in policies}, far) for quantity in shown]


def _plot(results: Results, axis: SweptAxis, quantity: Quantity, about: str, styles: Styles, far: Set[str]) -> Plot:
    span = axis.span
    series = [
        _series(results, axis, quantity, policy, style, (k - (len(styles) - 1) / 2) * APART * span)
        for k, (policy, style) in enumerate(styles.items())
    ]
    near = [each for each in series if each.name not in far] or series
    ends = [end for each in near for end in (*each.y, *(each.low or []), *(each.high or []))]
    ends += [value for each in near for _, value in each.dots or []]
    return Plot(
        title=quantity.heading,
        label=f"{quantity.heading} against {about}",
        x=PlotAxis(
            title=axis.title,
            low=axis.low - 0.07 * span,
            high=axis.low + 1.07 * span,
            ticks=tuple(zip(axis.places, axis.names, strict=True)),
        ),
        y=_upright(ends),
        series=series,
        beyond=_beyond([each.name for each in series if each not in near]),
    )


def _far(results: Results, axis: SweptAxis) -> set[str]:
    """Return the policies that are far behind in every scenario of the axis that they flew."""
    found = {name: far_behind(Comparison(results, name)) for name in axis.scenarios}
    near = {policy for name, policy in results.groups if name in found and policy not in found[name]}
    return {policy for names in found.values() for policy in names} - near


def _beyond(names: Sequence[str]) -> str:
    """Name the policies that no range is made for."""
    return f"Ranges are made without {', '.join(names)}, far behind." if names else ""


def _upright(ends: list[float]) -> PlotAxis:
    """Return the y axis around all that is drawn: logarithmic where it spans a factor of four or more."""
    low, high = min(ends), max(ends)
    if low > 0 and high >= WIDE * low:
        return PlotAxis(title="", low=low / 1.15, high=high * 1.15, log=True)
    margin = 0.08 * ((high - low) or 1.0)
    return PlotAxis(title="", low=max(0.0, low - margin), high=high + margin)


def _places(reaches: tuple[float, ...]) -> tuple[float, ...]:
    """Return where on the axis each range is drawn: an unlimited one a quarter beyond the longest, or at 1."""
    longest = max(far for far in reaches if far < math.inf)
    return tuple(far if far < math.inf else 1.25 * longest or 1.0 for far in reaches)


def _series(
    results: Results, axis: SweptAxis, quantity: Quantity, policy: str, style: PolicyStyle, offset: float
) -> PlotSeries:
    flown = [k for k, name in enumerate(axis.scenarios) if (name, policy) in results.groups]
    names = [axis.scenarios[k] for k in flown]
    samples = [results.values(name, policy, quantity.metric) / quantity.divisor for name in names]
    maps = [results.maps(name, policy) for name in names]
    estimates = [bootstrap_mean(values, maps=here) for values, here in zip(samples, maps, strict=True)]
    low, high = bounds(estimates)
    x = [axis.places[k] + offset for k in flown]
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
        text=[
            f"{axis.word} {axis.names[k]}: {_text(estimate, quantity)}"
            for k, estimate in zip(flown, estimates, strict=True)
        ],
    )


def _text(estimate: Estimate, quantity: Quantity) -> str:
    shown = with_interval(estimate, quantity.decimals) if estimate.mean else fixed(0.0, 0)
    return f"{quantity.title} {shown} {quantity.unit}".strip()
