"""Print figures of profiles, Pareto front, rank plot and sweeps, drawn from the same data as on the page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from matplotlib.axes import Axes
from matplotlib.axis import Axis as MatplotlibAxis
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, ScalarFormatter

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.outliers import far_behind
from indoor_explorers.evaluation.analysis.panels.pareto_plot import pareto_plot
from indoor_explorers.evaluation.analysis.panels.performance_profile import profile_plot
from indoor_explorers.evaluation.analysis.panels.plot_data import Plot, PlotAxis, PlotSeries
from indoor_explorers.evaluation.analysis.panels.rank_plot import Improvement, RankRow, rank_rows
from indoor_explorers.evaluation.analysis.panels.sweep_panels import SweepPanel, sweep_sections
from indoor_explorers.evaluation.analysis.task_times import TaskTimes
from indoor_explorers.evaluation.drawing.formatting import counted
from indoor_explorers.evaluation.drawing.palette import PolicyStyle, Styles
from indoor_explorers.evaluation.drawing.print_style import COLUMN, PAGE, percent_axis, plain, strokes
from indoor_explorers.evaluation.exports.figures.layout import add_legend, add_note, paper
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.statistics import FEWEST

#: Plots in a row.
COLUMNS = 3


def scenario_figures(comparison: Comparison, styles: Styles) -> Iterator[tuple[str, Figure]]:
    """Yield the figures of a scenario that have content, by the end of their file name."""
    task_times = TaskTimes.of(comparison)
    profile = profile_plot(task_times, styles, far_behind(comparison))
    pareto, rows = pareto_plot(comparison, styles), rank_rows(task_times)
    if profile is not None:
        tasks = counted(len(task_times.common().tasks), "task")
        note = f"{tasks} flown by all policies; a curve that stays below 100 % has unsolved tasks."
        yield "profile", _alone(profile, comparison, styles, note)
    if pareto is not None:
        how = "" if any(each.dots for each in pareto.series) else " with 95 % bootstrap interval"
        note = f"Mean AUC{how}; median time of a decision, whisker to the 99th percentile. Filled: the Pareto front."
        shares = [policy for policy in comparison.groups if policy in comparison.results.batched_policies]
        note += f" Times that are shares of a batch: {', '.join(map(plain, shares))}." if shares else ""
        note += f" {pareto.beyond}"
        yield "pareto", _alone(pareto, comparison, styles, note)
    if rows:
        yield "rank-plot", rank_figure(comparison, rows, styles)


def sweep_figures(results: Results, styles: Styles) -> Iterator[tuple[str, Figure]]:
    """Yield a figure for each sweep of radio and team, and one for the sweeps of all other settings, by file name."""
    sections = sweep_sections(results, styles)
    for kind, panels in (("radio", sections.radio), ("teams", sections.team)):
        for number, panel in enumerate(panels, 1):
            yield f"{kind}-{number:02d}", _sweep_figure(panel.title, [panel], styles)
    if sections.setting:
        yield "settings", _sweep_figure("Scenarios that differ in one setting", sections.setting, styles)


def _alone(plot: Plot, comparison: Comparison, styles: Styles, note: str) -> Figure:
    names = [series.name for series in plot.series]
    figure = paper(COLUMN, 2.5, names)
    axes = figure.add_subplot()
    draw(axes, plot)
    axes.set_title(plain(comparison.title, 40))
    add_legend(figure, names, styles)
    add_note(figure, note)
    return figure


def _sweep_figure(title: str, panels: Sequence[SweepPanel], styles: Styles) -> Figure:
    """Draw the plots of all panels, which have equally many episodes a point, under one title."""
    plots = [plot for panel in panels for plot in panel.plots]
    columns = min(COLUMNS, len(panels[0].plots))
    rows = -(-len(plots) // columns)
    names = list(dict.fromkeys(name for panel in panels for name in panel.policies))
    figure = paper(PAGE, 0.3 + 2.1 * rows, names)
    for place, plot in enumerate(plots, 1):
        axes = figure.add_subplot(rows, columns, place)
        draw(axes, plot)
        axes.set_title(plot.title)
    figure.suptitle(plain(title, 90), x=0.01, ha="left", fontsize=10)
    add_legend(figure, names, styles)
    few, hollow = any(panel.few for panel in panels), any(panel.hollow for panel in panels)
    how = "too few for intervals, each is a dot" if few else "95 % bootstrap intervals"
    add_note(
        figure,
        f"{panels[0].tasks} episodes a point, {how}. {'Hollow: some episodes did not reach the threshold.' * hollow} "
        f"{panels[0].beyond}",
    )
    return figure


def draw(axes: Axes, plot: Plot) -> None:
    """Draw a plot without its title."""
    for guide in plot.guides:
        style = "steps-post" if guide.step else "default"
        axes.plot(guide.x, guide.y, color="#888888", linewidth=0.9, linestyle=(0, (4, 3)), drawstyle=style, zorder=1)
    for series in plot.series:
        _draw_series(axes, series)
    axes.set_xscale("log" if plot.x.log else "linear")
    axes.set_yscale("log" if plot.y.log else "linear")
    axes.set(xlim=(plot.x.low, plot.x.high), ylim=(plot.y.low, plot.y.high), xlabel=plot.x.title, ylabel=plot.y.title)
    _ticks(axes.xaxis, plot.x)
    _ticks(axes.yaxis, plot.y)


def _ticks(axis: MatplotlibAxis, about: PlotAxis) -> None:
    if about.ticks:
        axis.set_ticks([place for place, _ in about.ticks], [text for _, text in about.ticks])
        axis.set_minor_formatter(NullFormatter())
    elif about.log and about.high < 30 * about.low:
        axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.set_major_formatter(ScalarFormatter())
        axis.set_minor_formatter(NullFormatter())
    elif not about.log:
        axis.set_major_locator(MaxNLocator(5))
    if about.share:
        percent_axis(axis)


def _draw_series(axes: Axes, series: PlotSeries) -> None:
    """Draw one policy: episodes, intervals, whiskers, the line, and hollow or filled markers."""
    stroke = strokes(series.style)
    if series.dots:
        x, y = zip(*series.dots, strict=True)
        axes.scatter(x, y, s=7, color=stroke["color"], alpha=0.4, linewidths=0, zorder=2)
    bars = {"color": stroke["color"], "linewidth": 0.9, "zorder": 2}
    if series.low is not None and series.high is not None:
        axes.vlines(series.x, series.low, series.high, **bars)
    if series.right is not None:
        axes.hlines(series.y, series.x, series.right, **bars)
    line = stroke | {"linestyle": stroke["linestyle"] if series.line else "none", "zorder": 3}
    if series.step:
        axes.plot(series.x, series.y, **line, drawstyle="steps-post", markevery=max(1, len(series.x) // 5))
        return
    axes.plot(series.x, series.y, **line)
    hollow = [place for place, empty in enumerate(series.hollow or []) if empty]
    rim = {"markerfacecolor": "white", "markeredgewidth": 1.0, "linestyle": "none", "zorder": 4}
    axes.plot([series.x[k] for k in hollow], [series.y[k] for k in hollow], **stroke | rim)


def rank_figure(comparison: Comparison, rows: Sequence[RankRow], styles: Styles) -> Figure:
    """Draw how often each policy is better than the next one and than the first one."""
    figure = paper(PAGE, 0.8 + 0.24 * len(rows))
    pair = figure.subplots(1, 2, sharey=True)
    titles = ("better than the next below", f"better than {plain(rows[0].policy, 24)}")
    for axes, title, which in zip(pair, titles, ("next", "best"), strict=True):
        for place, row in enumerate(rows):
            improvement = row.next if which == "next" else row.best
            if improvement is not None:
                _draw_improvement(axes, place, improvement, styles[row.policy])
        axes.axvline(0.5, color="#888888", linewidth=0.9, linestyle=(0, (4, 3)), zorder=1)
        axes.set(xlim=(-0.03, 1.03), ylim=(len(rows) - 0.4, -0.6), xlabel=f"{title} [share of tasks]")
        axes.set_xticks([0, 0.25, 0.5, 0.75, 1], ["0 %", "25 %", "50 %", "75 %", "100 %"])
        axes.tick_params(axis="y", length=0)
        axes.spines["left"].set_visible(False)
    pair[0].set_yticks(range(len(rows)), [plain(row.policy) for row in rows])
    pair[0].set_title(plain(comparison.title, 70))
    tasks = ", ".join(dict.fromkeys(row.tasks for row in rows if row.tasks))
    add_note(
        figure,
        f"Fewer steps to {comparison.level.percent} coverage, ties one half; {tasks} tasks, 95 % bootstrap intervals "
        f"from {FEWEST} on.",
    )
    return figure


def _draw_improvement(axes: Axes, place: int, improvement: Improvement, style: PolicyStyle) -> None:
    stroke = strokes(style)
    mean, low, high = improvement.estimate
    if low is not None and high is not None:
        axes.hlines([place], low, high, color=stroke["color"], linewidth=1.6, zorder=2)
    else:
        axes.scatter(
            improvement.scores,
            [place + 0.2] * len(improvement.scores),
            s=7,
            color=stroke["color"],
            alpha=0.4,
            linewidths=0,
        )
    axes.plot([mean], [place], **stroke | {"markersize": 5.2, "zorder": 3})
