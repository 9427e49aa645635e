"""The figures of the thesis's experiments: scores, coverage by step, greedy evaluations, and all versions."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from indoor_explorers.evaluation.drawing.palette import COLOURS, DASHES, MARKERS
from indoor_explorers.evaluation.drawing.print_style import (
    grid_below,
    legend_beside,
    percent_axis,
    print_style,
    save_in_own_size,
    sheet,
)
from indoor_explorers.evaluation.studies.thesis.experiments import GROUPS
from indoor_explorers.evaluation.studies.thesis.results import Run

#: Smallest window of the moving average, that of the thesis; long trainings use a hundredth of their length.
LEAST_WINDOW = 10
#: Scores below minus this are drawn on a logarithmic scale, so that the others stay visible.
LARGE = 20_000.0
#: Steps of an episode in all of the thesis's experiments.
BUDGET = 400
#: Indices in the palette: version thesis is vermillion, mended blue; single switches follow.
_HUES = (1, 0, 2, 3, 4, 5, 6)


def write_figures(runs: Sequence[Run], folder: Path) -> list[Path]:
    """Write all figures as SVG and PNG and return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    with print_style():
        return [path for stem, figure in figures(runs) for path in save_in_own_size(figure, folder, stem)]


def figures(runs: Sequence[Run]) -> Iterator[tuple[str, Figure]]:
    """Yield names and figures: the end results of all versions, and three figures for each group of experiments."""
    yield "versions", versions_figure(runs)
    for group in GROUPS:
        own = [run for run in runs if run.experiment.group == group]
        if own:
            yield f"{group}-scores", grid_figure(own, "Score of each training episode", _scores, "score")
            yield f"{group}-coverage", coverage_figure(own)
            yield f"{group}-greedy", grid_figure(own, "Greedy evaluation, apart from training", _reached, "share")


def _names(runs: Sequence[Run]) -> tuple[list[str], list[str]]:
    """Return the experiments' titles and the versions, each once, in order."""
    return list(dict.fromkeys(run.experiment.title for run in runs)), list(dict.fromkeys(run.version for run in runs))


def hue_of(versions: Sequence[str], version: str) -> str:
    """Return the colour of a version among those that are drawn."""
    return COLOURS[_HUES[versions.index(version) % len(_HUES)]][0]


def _sheet(width: float, height: float, title: str) -> Figure:
    figure = sheet(width, height, fitted=True)
    figure.suptitle(title, x=0.01, ha="left", fontsize=10.5, fontweight="bold")
    return figure


def grid_figure(runs: Sequence[Run], title: str, draw: Callable[[Axes, Run, str], None], label: str) -> Figure:
    """Draw one panel for each experiment and version, experiments side by side."""
    titles, versions = _names(runs)
    figure = _sheet(max(8.2, 1.0 + 2.5 * len(titles)), 0.7 + 1.75 * len(versions), title)
    panels = figure.subplots(len(versions), len(titles), sharex="col", sharey=True, squeeze=False)
    by_place = {(run.version, run.experiment.title): run for run in runs}
    for row, version in zip(panels, versions, strict=True):
        for axes, name in zip(row, titles, strict=True):
            if (version, name) in by_place:
                draw(axes, by_place[version, name], hue_of(versions, version))
            axes.xaxis.set_major_locator(MaxNLocator(4, integer=True))
            axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}"))
            grid_below(axes)
        row[0].set_ylabel(f"{version}\n{label}")
    for axes, name in zip(panels[0], titles, strict=True):
        axes.set_title(name, fontsize=8.5)
    for axes in panels[-1]:
        axes.set_xlabel("training episode")
    return figure


def _scores(axes: Axes, run: Run, hue: str) -> None:
    """Draw the scores of a run."""
    size = 1.6 if len(run.scores) > 5000 else 2.6
    draw_scores(axes, run.scores, color=hue, markersize=size, rasterized=True)
    if run.scores.min() < -LARGE:
        axes.set_yscale("symlog", linthresh=1000.0)


def draw_scores(axes: Axes, scores: NDArray[np.float64], every: int = 1, **look: Any) -> None:
    """Draw scores (E,), one for ``every`` episodes, and their moving average."""
    episodes = np.arange(1, len(scores) + 1) * every
    axes.plot(episodes, scores, ".", **{"alpha": 0.35, "markeredgewidth": 0} | look)
    window = max(LEAST_WINDOW, len(scores) // 100)
    mean = moving_average(scores, window)
    axes.plot(episodes[len(episodes) - len(mean) :], mean, color="#222222", linewidth=1.0)
    axes.axhline(0.0, color="#999999", linewidth=0.6)


def moving_average(values: NDArray[np.float64], window: int) -> NDArray[np.float64]:
    """Return the moving average (N - window + 1,) of ``values`` (N,); of all if they are fewer than ``window``."""
    window = min(window, len(values))
    return np.asarray(np.convolve(values, np.full(window, 1.0 / window), "valid"))


def _reached(axes: Axes, run: Run, hue: str) -> None:
    """Draw the share of greedy episodes with 90 %, of crashed UAVs, and the mean coverage, over the training."""
    lines = (("reached", "90 % reached", "-", hue), ("coverage", "coverage at the end", (0, (4, 2)), hue))
    for figure, label, dash, colour in (*lines, ("crashed", "UAVs crashed", (0, (1, 1.5)), "#444444")):
        axes.plot(run.greedy("episodes"), run.greedy(figure), color=colour, linestyle=dash, linewidth=1.3, label=label)
    axes.set(xlim=(0, 1.03 * run.greedy("episodes")[-1]), ylim=(-0.03, 1.03))
    percent_axis(axes.yaxis)
    if axes.get_subplotspec().is_first_row() and axes.get_subplotspec().is_last_col():  # type: ignore[union-attr]
        legend_beside(axes)


def coverage_figure(runs: Sequence[Run]) -> Figure:
    """Draw coverage by step of training episodes, as the thesis does, and of the last greedy evaluation."""
    titles, versions = _names(runs)
    figure = _sheet(8.2, 0.8 + 2.3 * len(versions), "Coverage of the map by step")
    panels = figure.subplots(len(versions), 2, sharex=True, sharey=True, squeeze=False)
    for row, version in zip(panels, versions, strict=True):
        for run in (each for each in runs if each.version == version):
            place = titles.index(run.experiment.title)
            look: dict[str, Any] = {"color": COLOURS[place][0], "linewidth": 1.3, "label": run.experiment.title}
            look["linestyle"] = (0, DASHES[place]) if DASHES[place] else "-"
            for axes, curve in zip(row, (training_curve(run), greedy_curve(run)), strict=True):
                axes.plot(np.arange(len(curve)), curve, **look)
        row[0].set_ylabel(f"{version}\ncoverage")
        for axes in row:
            axes.axhline(0.9, color="#999999", linewidth=0.6, linestyle=(0, (1, 2)))
            axes.set(xlim=(0, BUDGET), ylim=(0, 1.01))
            percent_axis(axes.yaxis)
    panels[0][0].set_title("training: episodes still flying", fontsize=8.5)
    panels[0][1].set_title("greedy, at the end: all episodes", fontsize=8.5)
    legend_beside(panels[0][1])
    for axes in panels[-1]:
        axes.set_xlabel("step")
    return figure


def training_curve(run: Run) -> list[float]:
    """Return the mean coverage by step of training episodes, NaN for step 0, which training does not record."""
    return [float("nan"), *run.record["training_coverage_by_step"]]


def greedy_curve(run: Run) -> list[float]:
    """Return the mean coverage by step of the last greedy evaluation, continued at its last value to the budget."""
    curve = list(run.record["greedy_coverage_by_step"])
    return curve + curve[-1:] * (BUDGET + 1 - len(curve))


def versions_figure(runs: Sequence[Run]) -> Figure:
    """Draw the end results of each experiment by version: greedy episodes that reached 90 %, coverage, and T90."""
    names = list(dict.fromkeys(run.experiment.name for run in runs))
    _, versions = _names(runs)
    rows, legend = max(0.3, 0.12 * len(versions)) * len(names), 0.2 * len(versions)
    figure = _sheet(
        8.2,
        1.1 + max(rows, legend),
        "Greedy, at the end of training: the thesis's learner, as it was and corrected",
    )
    panels = figure.subplots(1, 3, sharey=True)
    figures = (("reached", "90 % reached"), ("coverage", "coverage"), ("t90", "T90 [steps]"))
    for axes, (key, label) in zip(panels, figures, strict=True):
        for rank, version in enumerate(versions):
            own = [run for run in runs if run.version == version]
            beside = 0.6 * (rank - (len(versions) - 1) / 2) / len(versions)  # so that equal values are both visible
            places = [names.index(run.experiment.name) + beside for run in own]
            dots: dict[str, Any] = {"color": hue_of(versions, version), "marker": MARKERS[rank % len(MARKERS)][1]}
            axes.plot([run.greedy(key)[-1] for run in own], places, linestyle="", label=version, markersize=5, **dots)
        axes.set(
            xlabel=label, ylim=(len(names) - 0.5, -0.5), xlim=(-0.04, 1.04) if key != "t90" else (0, 1.04 * BUDGET)
        )
        grid_below(axes)
        if key != "t90":
            axes.set_xticks([0.0, 0.5, 1.0])
            percent_axis(axes.xaxis)
    panels[0].set_yticks(range(len(names)), names)
    legend_beside(panels[-1])
    return figure
