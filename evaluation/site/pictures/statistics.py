"""The pictures of the page on statistics: small examples, computed by the functions that the report uses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from indoor_explorers.evaluation.analysis.ranks import Rank
from indoor_explorers.evaluation.drawing.formatting import fixed, p_value, percent
from indoor_explorers.evaluation.drawing.palette import COLOURS
from indoor_explorers.evaluation.site.pictures.drawing import svg
from indoor_explorers.evaluation.statistics import (
    CONFIDENCE,
    Estimate,
    all_pairs_test,
    bootstrap_mean,
    bootstrap_means,
    curve_band,
    ecdf_of_times,
    paired_difference,
    tied_ranks,
)

BLUE, ORANGE, GREY = COLOURS[0][0], COLOURS[1][0], "#888888"
DASHED = (0, (4, 3))
#: A text beside a point.
BESIDE: dict[str, Any] = {"textcoords": "offset points", "va": "center"}
#: Inches; about 700 pixels on the page.
WIDTH = 7.0
#: Steps of two policies to the threshold on the same four tasks, NaN for never, and the budget.
TIMES, BUDGET = {"A": (50.0, 60.0, 90.0, 95.0), "B": (50.0, 60.0, np.nan, np.nan)}, 100
#: Maps of a simulated comparison, its episodes on each map, and how many comparisons are simulated and drawn.
MAPS, EPISODES, SIMULATED, DRAWN = 8, (1, 2, 5, 10, 20, 50), 1000, 40
DRAWN_EPISODES = 10
#: Curves of a simulated sample, their steps, the mean share of the unknown that a step uncovers, and the samples.
CURVES, STEPS, UNCOVERED, SAMPLES = 20, 60, 0.05, 400
#: Mean steps of simulated policies more than A, on this many tasks, and the spread of one policy on one task.
BEHIND, TASKS, SPREAD = {"A": 0.0, "B": 1.2, "C": 2.6, "D": 9.0}, 20, 2.5
#: Resamples of a simulated interval.
RESAMPLES = 500


def statistics_pictures() -> dict[str, bytes]:
    """Return the SVG files of the page by name."""
    drawn = {"never": _never, "maps": _maps, "ranks": _ranks, "bands": _bands}
    return {f"statistics-{name}.svg": svg(draw) for name, draw in drawn.items()}


def means_of_times(policy: str) -> tuple[float, float]:
    """Return the mean over the tasks that a policy of :data:`TIMES` solved, and its restricted mean."""
    times = np.array(TIMES[policy])
    return float(np.nanmean(times)), bootstrap_mean(np.where(np.isnan(times), BUDGET, times)).mean


def _never(figure: Figure) -> None:
    figure.set_size_inches(WIDTH, 3.2)
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(1.7, 1))
    for policy, colour, marker, wide, note in (
        ("A", BLUE, "o", 3.2, "A: all 4 tasks"),
        ("B", ORANGE, "s", 1.6, "B: 2 of 4 tasks, the harder two never"),
    ):
        steps, share = ecdf_of_times(TIMES[policy], BUDGET)
        top.step(steps, share, where="post", color=colour, linewidth=wide)
        top.annotate(note, (BUDGET, share[-1]), (8, 0), color=colour, **BESIDE)
        for row, mean in enumerate(means_of_times(policy)):
            lower = mean == min(means_of_times(each)[row] for each in TIMES)
            bottom.plot(mean, -row, marker=marker, color=colour, markersize=7)
            text, ends = f"{policy}: {mean:g}", {"ha": "right" if lower else "left", "color": colour}
            bottom.annotate(text, (mean, -row), (-9 if lower else 9, 0), **BESIDE, **ends)
    for row, verdict in enumerate(("B looks faster", "A is faster")):
        bottom.annotate(verdict, (BUDGET, -row), (8, 0), weight="bold", **BESIDE)
    for axes in (top, bottom):
        axes.axvline(BUDGET, color=GREY, linewidth=0.8, linestyle=DASHED)
        axes.spines["bottom"].set_bounds(0, BUDGET)
    top.set_title("Share of tasks on which the threshold was reached by each step")
    top.set(ylim=(0, 1.05), yticks=[0, 0.5, 1], yticklabels=["0 %", "50 %", "100 %"])
    bottom.set(yticks=[0, -1], yticklabels=["mean over the\ntasks it solved", "restricted mean,\nnever = budget"])
    bottom.set(xlim=(0, 158), xticks=range(0, BUDGET + 1, 20), ylim=(-1.6, 0.6))
    bottom.set_xlabel(f"steps; the budget is {BUDGET}", x=BUDGET / 158 / 2)


def intervals_on_maps(each: int) -> dict[str, NDArray[np.float64]]:
    """Return (SIMULATED, 2) intervals by what is drawn, with ``each`` episodes a map; the true mean is 0.

    A value is the effect of its map plus noise, both normal with a standard deviation of 1.
    """
    rng = np.random.default_rng(each)
    maps = np.repeat(np.arange(MAPS), each)
    values = rng.normal(0, 1, (MAPS, SIMULATED))[maps] + rng.normal(0, 1, (len(maps), SIMULATED))
    return {
        "over episodes": _ends(bootstrap_means(values, resamples=RESAMPLES)),
        "over maps": _ends(bootstrap_means(values, resamples=RESAMPLES, maps=maps)),
    }


def hold(intervals: NDArray[np.float64], truth: float | NDArray[np.float64] = 0.0) -> NDArray[np.bool_]:
    """Return which of (N, 2) intervals hold the true value."""
    return np.asarray((intervals[:, 0] <= truth) & (truth <= intervals[:, 1]))


def _ends(estimates: list[Estimate]) -> NDArray[np.float64]:
    return np.array([[each.low, each.high] for each in estimates], np.float64)


def _maps(figure: Figure) -> None:
    figure.set_size_inches(WIDTH, 3.4)
    found = {each: intervals_on_maps(each) for each in EPISODES}
    left, middle, right = figure.subplots(1, 3, width_ratios=(1, 1, 1.05))
    left.sharex(middle)
    for axes, (drawn, intervals) in zip((left, middle), found[DRAWN_EPISODES].items(), strict=True):
        holding = hold(intervals)
        for row, (ends, holds) in enumerate(zip(intervals[:DRAWN], holding[:DRAWN], strict=True)):
            axes.plot(ends, [row, row], color=BLUE if holds else ORANGE, linewidth=1.0 if holds else 2.4)
        axes.axvline(0, color="black", linewidth=0.8)
        axes.set_yticks([])
        axes.spines["left"].set_visible(False)
        axes.set_title(f"{drawn}: {percent(holding.mean())}\nhold the true mean", fontsize=8.5)
        axes.set_xlabel(f"{MAPS} maps, {DRAWN_EPISODES} episodes on each;\nthick: misses the true mean, 0")
    left.set_ylabel(f"{DRAWN} of {SIMULATED} simulated intervals")
    for drawn, colour, marker in (("over episodes", ORANGE, "s"), ("over maps", BLUE, "o")):
        shares = [hold(found[each][drawn]).mean() for each in EPISODES]
        right.plot(range(len(EPISODES)), shares, color=colour, marker=marker, markersize=4.5)
        right.annotate(drawn, (2.7, shares[3]), (0, 9), textcoords="offset points", color=colour)
    right.axhline(CONFIDENCE, color=GREY, linewidth=0.8, linestyle=DASHED)
    right.set(xticks=range(len(EPISODES)), xticklabels=EPISODES, xlabel=f"episodes on each of {MAPS} maps")
    right.set(ylim=(0, 1.07), yticks=[0, 0.5, CONFIDENCE], yticklabels=["0 %", "50 %", percent(CONFIDENCE)])
    right.set_title("share of intervals that\nhold the true mean", fontsize=8.5)


class SampleOfCurves(NamedTuple):
    """Intervals of the mean of simulated curves of coverage, (STEPS, 2)."""

    pointwise: NDArray[np.float64]
    band: NDArray[np.float64]

    @property
    def missed(self) -> NDArray[np.bool_]:
        """The steps at which the pointwise interval misses the true mean."""
        return ~hold(self.pointwise, true_curve())

    @property
    def in_band(self) -> bool:
        """Whether the band holds the true mean at all steps."""
        return bool(hold(self.band, true_curve()).all())


def true_curve() -> NDArray[np.float64]:
    """Return the (STEPS,) true mean of the simulated curves."""
    return np.asarray(1 - (1 - UNCOVERED) ** np.arange(1, STEPS + 1))


def samples_of_curves() -> Iterator[SampleOfCurves]:
    """Yield samples of curves: each step of a curve uncovers a random share of what is unknown."""
    rng = np.random.default_rng(0)
    for _ in range(SAMPLES):
        unknown = np.cumprod(1 - rng.beta(1, 1 / UNCOVERED - 1, (CURVES, STEPS)), axis=1)
        curves = np.asarray(1 - unknown, np.float64)
        _, low, high = curve_band(curves, resamples=RESAMPLES)
        pointwise = _ends(bootstrap_means(curves, resamples=RESAMPLES))
        yield SampleOfCurves(pointwise, np.stack((low, high), axis=1))


def shares_of_curves(samples: Sequence[SampleOfCurves]) -> dict[str, float]:
    """Return how often the true mean is held: at one step, and at all steps at once."""
    return {
        "pointwise,\nat one step": 1 - float(np.mean([each.missed for each in samples])),
        "pointwise,\nat all steps": 1 - float(np.mean([each.missed.any() for each in samples])),
        "band,\nat all steps": float(np.mean([each.in_band for each in samples])),
    }


def _bands(figure: Figure) -> None:
    figure.set_size_inches(WIDTH, 2.9)
    left, right = figure.subplots(1, 2, width_ratios=(1.5, 1))
    samples = list(samples_of_curves())
    shown = next(each for each in samples if each.missed.any() and each.in_band)
    steps, truth, missed = np.arange(1, STEPS + 1), true_curve(), shown.missed
    left.fill_between(steps, *shown.band.T, color="#c3dcee", linewidth=0, label="band")
    left.fill_between(steps, *shown.pointwise.T, color="#5f9fca", linewidth=0, label="pointwise intervals")
    left.plot(steps, truth, color="black", linewidth=1.4, linestyle=DASHED, label="true mean")
    left.plot(steps[missed], truth[missed], "s", color=ORANGE, markersize=3, label="missed by pointwise intervals")
    left.set(xlabel="steps", ylabel="coverage", ylim=(0, 1.02))
    left.set(yticks=[0, 0.5, 1], yticklabels=["0 %", "50 %", "100 %"])
    left.set_title(f"Mean of {CURVES} simulated curves")
    left.legend(loc="lower right")
    shares = shares_of_curves(samples)
    for row, (share, colour) in enumerate(zip(shares.values(), ("#6b6b6b", ORANGE, BLUE), strict=True)):
        right.barh(-row, share, height=0.6, color=colour)
        right.annotate(percent(share), (0, -row), (5, 0), color="white", weight="bold", **BESIDE)
    right.axvline(CONFIDENCE, color=GREY, linewidth=0.8, linestyle=DASHED)
    right.set(yticks=[0, -1, -2], yticklabels=list(shares), xlim=(0, 1), xlabel=f"of {SAMPLES} such samples")
    right.set(xticks=[0, 0.5, CONFIDENCE], xticklabels=["0 %", "50 %", percent(CONFIDENCE)])
    right.set_title("Holds the true mean")


def league() -> NDArray[np.float64]:
    """Return the (TASKS, 4) simulated steps of the policies on the same tasks."""
    rng = np.random.default_rng(0)
    tasks = rng.normal(60.0, 10.0, (TASKS, 1))
    return np.asarray(tasks + np.array(list(BEHIND.values())) + rng.normal(0.0, SPREAD, (TASKS, len(BEHIND))))


def _ranks(figure: Figure) -> None:
    figure.set_size_inches(WIDTH, 2.7)
    left, right = figure.subplots(1, 2, width_ratios=(1, 1.65))
    values = league()
    adjusted_p = all_pairs_test(values).adjusted_p
    _league_table(left, values, adjusted_p)
    _differences(right, values, adjusted_p)


def _league_table(axes: Any, values: NDArray[np.float64], adjusted_p: NDArray[np.float64]) -> None:
    """Write the table; the policies are in the order of their means."""
    names, places = list(BEHIND), tied_ranks(values)
    rows = [("rank", "policy", "mean", "significantly\nfaster ones")]
    for k, (name, mean, place) in enumerate(zip(names, values.mean(axis=0).tolist(), places, strict=True)):
        faster = [names[j] for j in range(k) if adjusted_p[j, k] <= 1 - CONFIDENCE]
        rows.append((Rank(place, places.count(place) > 1).text, name, fixed(mean, 1), ", ".join(faster) or "none"))
    for row, cells in enumerate(rows):
        for x, text in zip((0.0, 0.85, 1.95, 2.9), cells, strict=True):
            axes.text(x, -row, text, va="center", weight="bold" if row == 0 else "normal")
    axes.set(xlim=(-0.1, 4.6), ylim=(-len(rows), 0.5), title=f"T99 on {TASKS} tasks")
    axes.set_axis_off()


def _differences(axes: Any, values: NDArray[np.float64], adjusted_p: NDArray[np.float64]) -> None:
    """Draw the differences of all pairs with their intervals; hollow where not significant."""
    pairs = list(combinations(range(len(BEHIND)), 2))
    for row, (one, other) in enumerate(pairs):
        found, p = paired_difference(values[:, other], values[:, one]), float(adjusted_p[one, other])
        shown = p <= 1 - CONFIDENCE
        colour = BLUE if shown else ORANGE
        axes.plot([found.low, found.high], [-row, -row], color=colour, linewidth=1.6)
        axes.plot(found.mean, -row, marker="o" if shown else "s", color=colour, mfc=colour if shown else "white")
        text = f"p {p_value(p)}{'' if shown else ', not significant'}"
        axes.annotate(text, (13, -row), (0, 0), color=colour, **BESIDE)
    axes.axvline(0, color="black", linewidth=0.8)
    labels = [f"{other} minus {one}" for one, other in combinations(BEHIND, 2)]
    axes.set(yticks=[-row for row in range(len(pairs))], yticklabels=labels, xlim=(-1.5, 20), xticks=range(0, 13, 4))
    axes.spines["bottom"].set_bounds(-1.5, 12.5)
    axes.set_xlabel("difference of steps, 95 % interval of each alone", x=0.33)
    axes.set_title("All differences, p adjusted for all of them")
