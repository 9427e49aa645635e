"""Figures for print: coverage curves, and T90 and T99 as dots with intervals; SVG, PNG and PDF.

Equal results give equal bytes: no dates, fixed ids. Policies differ by dash and marker as well as by
colour, so the figures survive a greyscale printer.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, PercentFormatter

from indoor_explorers.env.files import written_whole
from indoor_explorers.evaluation.report.axes import coverage_at, focus_step, sampled_steps
from indoor_explorers.evaluation.report.comparison import Comparison
from indoor_explorers.evaluation.report.facts import denominator
from indoor_explorers.evaluation.report.palette import DASHES, MARKERS, Style, styles
from indoor_explorers.evaluation.results import Results
from indoor_explorers.evaluation.statistics import FEWEST, curve_band

FORMATS: Mapping[str, dict[str, Any]] = {
    "svg": {"metadata": {"Date": None}},
    "png": {"metadata": {"Software": None}, "dpi": 200},
    "pdf": {"metadata": {"CreationDate": None}},
}
LOOK: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 8.5,
    "axes.labelsize": 8.5,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.titlepad": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "axes.edgecolor": "#444444",
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "legend.handlelength": 3.2,
    "svg.hashsalt": "indoor-explorers",
    "pdf.fonttype": 42,
}


def write_figures(results: Results, folder: Path) -> list[Path]:
    """Write the figures of every scenario into ``folder`` and return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    looks = styles(results.policies)
    paths = []
    with mpl.rc_context(LOOK):
        for number, scenario in enumerate(results.scenarios, 1):
            comparison = Comparison(results, scenario)
            if comparison.groups:
                stem = f"{number:02d}-{slug(scenario)}"
                paths += _save(coverage_figure(comparison, looks), folder, f"{stem}-coverage")
                paths += _save(times_figure(comparison, looks), folder, f"{stem}-t90-t99")
    return paths


def slug(name: str) -> str:
    """Return a name as part of a file name: small letters, digits and hyphens."""
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")[:60] or "scenario"


def _save(figure: Figure, folder: Path, stem: str) -> list[Path]:
    paths = []
    for ending, options in FORMATS.items():
        paths.append(folder / f"{stem}.{ending}")
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Glyph .* missing from font")
            with written_whole(paths[-1]) as partial:
                figure.savefig(partial, format=ending, bbox_inches="tight", **options)
    return paths


def _figure(width: float, height: float) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    return figure, figure.add_subplot()


def _plain(name: str, most: int = 40) -> str:
    """Return a name that matplotlib neither reads as mathematics nor hides from a legend."""
    name = name if len(name) <= most else name[: most - 1] + "…"
    return ("\u200a" if name.startswith("_") else "") + name.replace("\\", "\u29f5").replace("$", r"\$")


def _label(comparison: Comparison, policy: str) -> str:
    return _plain(policy) + (" (knows the map)" if comparison.privileged(policy) else "")


def coverage_figure(comparison: Comparison, looks: Mapping[str, Style]) -> Figure:
    """Draw mean coverage by step with 95 % bands, up to where little happens any more."""
    figure, axes = _figure(6.3, max(3.1, 0.17 * len(comparison.groups) + 0.4))
    steps = sampled_steps(comparison, 400)
    limit = focus_step(comparison)
    handles = [_curve(axes, comparison, policy, steps, limit, looks[policy]) for policy in comparison.groups]
    for level in (0.9, 0.99):
        axes.axhline(level, color="#999999", linewidth=0.6, linestyle=(0, (1, 2)), zorder=0)
    axes.set(xlim=(0, limit), ylim=(0, 1.01), xlabel="step", title=_plain(comparison.scenario, 70))
    settings = comparison.results.scenarios[comparison.scenario]
    axes.set_ylabel("coverage of the team:\n" + denominator(settings).replace("free cells ", "free cells\n"))
    axes.set_yticks([0, 0.25, 0.5, 0.75, 0.9, 0.99])
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0, symbol=" %"))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    labels = [_label(comparison, policy) for policy in comparison.groups]
    axes.legend(handles, labels, loc="upper left", bbox_to_anchor=(1.04, 1.0), borderaxespad=0.0)
    _footnote(axes, comparison)
    return figure


def _curve(axes: Axes, comparison: Comparison, policy: str, steps: np.ndarray, limit: int, look: Style) -> Line2D:
    """Draw one policy's curve, its markers spread over the visible steps and offset from its neighbours'."""
    mean, low, high = curve_band(coverage_at(comparison.groups[policy], steps), maps=comparison.maps(policy))
    if not np.isnan(low).any():
        axes.fill_between(steps, low, high, color=look.hex, alpha=0.16, linewidth=0)
    visible = max(1, int((steps <= limit).sum()))
    every = (look.marker * visible // 40 % max(1, visible // 6), max(1, visible // 6))
    (line,) = axes.plot(steps, mean, markevery=every, **_strokes(look))
    return line


def _strokes(look: Style) -> dict[str, Any]:
    return {
        "color": look.hex,
        "linewidth": 1.4,
        "linestyle": (0, tuple(0.6 * length for length in DASHES[look.dash])) if DASHES[look.dash] else "-",
        "marker": MARKERS[look.marker][1],
        "markersize": 4.2,
        "markeredgewidth": 0.0,
    }


def times_figure(comparison: Comparison, looks: Mapping[str, Style]) -> Figure:
    """Draw mean T90 and T99 of each policy, best at the top, over the dots of its episodes."""
    ranked = comparison.ranking
    figure = Figure(figsize=(6.3, 0.9 + 0.3 * len(ranked)))
    FigureCanvasAgg(figure)
    pair = figure.subplots(1, 2, sharey=True, gridspec_kw={"wspace": 0.08})
    for axes, metric, title in zip(pair, ("t90", "t99"), ("T90", "T99"), strict=True):
        for place, policy in enumerate(ranked):
            _time(axes, comparison, policy, metric, place, looks[policy])
        axes.set(xlabel=f"{title} [steps]", ylim=(len(ranked) - 0.4, -0.6))
        axes.set_xlim(left=0)
        axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))
        axes.grid(axis="x", color="#e3e3e3", linewidth=0.6)
        axes.set_axisbelow(True)
        axes.tick_params(axis="y", length=0)
        axes.spines["left"].set_visible(False)
    pair[0].set_yticks(range(len(ranked)), [_label(comparison, policy) for policy in ranked])
    pair[0].set_title(_plain(comparison.scenario, 70))
    _footnote(pair[0], comparison, "; hollow dots never got there")
    return figure


def _time(axes: Axes, comparison: Comparison, policy: str, metric: str, place: int, look: Style) -> None:
    values = comparison.results.values(comparison.scenario, policy, metric)
    estimate = comparison.estimate(policy, metric)
    missed = np.array([record.metrics.get(metric) is None for record in comparison.groups[policy]])
    dots: dict[str, Any] = {"s": 7, "color": look.hex, "alpha": 0.4, "linewidths": 0.5}
    below = place + 0.2
    axes.scatter(values[~missed], np.full(int((~missed).sum()), below), marker="o", **dots)
    axes.scatter(values[missed], np.full(int(missed.sum()), below), marker="o", facecolors="none", **_rim(dots))
    if estimate.low is not None and estimate.high is not None:
        axes.plot([estimate.low, estimate.high], [place - 0.12] * 2, color=look.hex, linewidth=1.6)
    axes.plot([estimate.mean], [place - 0.12], **_strokes(look) | {"markersize": 5.2})


def _rim(dots: dict[str, Any]) -> dict[str, Any]:
    return {("edgecolors" if key == "color" else key): value for key, value in dots.items()}


def _footnote(axes: Axes, comparison: Comparison, more: str = "") -> None:
    """Write below the axes what the figure is made of."""
    counts = [len(records) for records in comparison.groups.values()]
    span = f"{min(counts)}" if min(counts) == max(counts) else f"{min(counts)} to {max(counts)}"
    how = "95 % bootstrap intervals" if min(counts) >= FEWEST else "too few for intervals"
    text = f"Means over {span} episode{'' if max(counts) == 1 else 's'} a policy, {how}{more}."
    offset: dict[str, Any] = {"xytext": (0, -38), "textcoords": "offset points", "annotation_clip": False}
    axes.annotate(text, (0, 0), xycoords="axes fraction", fontsize=7, color="#666666", va="top", **offset)
