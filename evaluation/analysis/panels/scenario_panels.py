"""The panels of one scenario."""

from __future__ import annotations

from dataclasses import dataclass

from markupsafe import Markup

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.failures import failed_or_ended
from indoor_explorers.evaluation.analysis.outliers import far_behind
from indoor_explorers.evaluation.analysis.panels.failure_causes import Cause, causes
from indoor_explorers.evaluation.analysis.panels.pareto_plot import pareto_plot
from indoor_explorers.evaluation.analysis.panels.performance_profile import profile_plot
from indoor_explorers.evaluation.analysis.panels.plot_data import Plot
from indoor_explorers.evaluation.analysis.panels.rank_plot import Improvement, RankRow, rank_rows
from indoor_explorers.evaluation.analysis.panels.replay_links import ReplayCell
from indoor_explorers.evaluation.analysis.panels.times_by_map import TimesTable, times_table
from indoor_explorers.evaluation.analysis.panels.win_matrix import win_matrix
from indoor_explorers.evaluation.analysis.task_times import TaskTimes
from indoor_explorers.evaluation.drawing.palette import Styles


@dataclass(frozen=True)
class RankPlotRow:
    """A row of the rank plot with its drawings."""

    ranked: RankRow
    next_dot_plot: Markup | None
    best_dot_plot: Markup | None


@dataclass(frozen=True)
class ScenarioPanels:
    """The panels of a scenario; one without content is None or empty and is left out."""

    duels: list[tuple[str, list[ReplayCell]]]
    ranks: TimesTable | None
    rank_plot: list[RankPlotRow]
    pareto: Plot | None
    profile: Plot | None
    tasks: int
    """Number of tasks that all ranked policies flew."""
    episodes: str
    """Number of episodes of each policy."""
    causes: list[Cause]


def scenario_panels(comparison: Comparison, styles: Styles) -> ScenarioPanels:
    """Gather the panels of a scenario."""
    task_times = TaskTimes.of(comparison)
    records = comparison.records
    counts = sorted({len(records) for records in comparison.groups.values()})
    return ScenarioPanels(
        duels=win_matrix(task_times),
        ranks=times_table(comparison, task_times),
        rank_plot=[_plot_row(row, styles) for row in rank_rows(task_times)],
        pareto=pareto_plot(comparison, styles),
        profile=profile_plot(task_times, styles, far_behind(comparison)),
        tasks=len(task_times.common().tasks),
        episodes=" to ".join(str(count) for count in (counts[:1] + counts[-1:] if len(counts) > 1 else counts)),
        causes=causes(failed_or_ended(records), {policy: len(group) for policy, group in comparison.groups.items()}),
    )


def _plot_row(row: RankRow, styles: Styles) -> RankPlotRow:
    def dot_plot(improvement: Improvement | None) -> Markup | None:
        return improvement.dot_plot(styles[improvement.policy]) if improvement is not None else None

    return RankPlotRow(row, dot_plot(row.next), dot_plot(row.best))
