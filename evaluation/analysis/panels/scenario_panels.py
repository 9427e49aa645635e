"""The panels of one scenario."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.failures import by_cause, ending, failed_or_ended, uav_ends
from indoor_explorers.evaluation.analysis.outliers import far_behind
from indoor_explorers.evaluation.analysis.panels.pareto_plot import pareto_plot
from indoor_explorers.evaluation.analysis.panels.performance_profile import profile_plot
from indoor_explorers.evaluation.analysis.panels.plot_data import Plot
from indoor_explorers.evaluation.analysis.panels.rank_plot import RankRow, rank_rows
from indoor_explorers.evaluation.analysis.panels.replay_links import ReplayCell, replay_link
from indoor_explorers.evaluation.analysis.panels.times_by_map import TimesTable, times_table
from indoor_explorers.evaluation.analysis.panels.win_matrix import win_matrix
from indoor_explorers.evaluation.analysis.task_times import TaskTimes
from indoor_explorers.evaluation.drawing.formatting import EN_DASH, percent, span
from indoor_explorers.evaluation.drawing.palette import Styles
from indoor_explorers.evaluation.harness.episodes.record import Outcome, Record

#: Limit of seeds that a row lists.
SEEDS = 8


class Cause(NamedTuple):
    """The episodes of one policy that ended early for one cause."""

    policy: str
    cause: str
    """The message of the first of them."""
    episodes: int
    flown: int
    """All episodes of the policy."""
    coverage: str
    """At their ends, from lowest to highest."""
    seeds: str
    replay: str
    """Link to the replay of the first of them."""


def causes(troubles: Sequence[Record], flown: dict[str, int]) -> list[Cause]:
    """Return a row for each policy and cause, most frequent first; ``flown`` counts the episodes of each policy."""
    return [_cause(records, flown[records[0].policy]) for records in by_cause(troubles)]


def _cause(records: list[Record], flown: int) -> Cause:
    first, policy = records[0], records[0].policy
    ended = first.outcome is Outcome.ENDED
    cause = f"all UAVs ended {EN_DASH} {', '.join(uav_ends(first))}" if ended else ending(first)
    covered = sorted(float(record.curve[-1]) for record in records)
    spread = list(dict.fromkeys(percent(share, 1) for share in (covered[0], covered[-1])))
    seeds = list(dict.fromkeys(str(record.task.seed) for record in records))
    more = f" and {len(seeds) - SEEDS} more" if len(seeds) > SEEDS else ""
    coverage, listed = " to ".join(spread), ", ".join(seeds[:SEEDS]) + more
    return Cause(policy, cause, len(records), flown, coverage, listed, replay_link(policy, first.task))


@dataclass(frozen=True)
class ScenarioPanels:
    """The panels of a scenario; one without content is None or empty and is left out."""

    duels: list[tuple[str, list[ReplayCell]]]
    ranks: TimesTable | None
    rank_plot: list[RankRow]
    pareto: Plot | None
    profile: Plot | None
    tasks: int
    """Number of tasks that all ranked policies flew."""
    episodes: str
    """Number of episodes of each policy."""
    causes: list[Cause]
    styles: Styles


def scenario_panels(comparison: Comparison, styles: Styles) -> ScenarioPanels:
    """Gather the panels of a scenario."""
    task_times = TaskTimes.of(comparison)
    records = comparison.records
    return ScenarioPanels(
        duels=win_matrix(task_times),
        ranks=times_table(comparison, task_times),
        rank_plot=rank_rows(task_times),
        pareto=pareto_plot(comparison, styles),
        profile=profile_plot(task_times, styles, far_behind(comparison)),
        tasks=len(task_times.common().tasks),
        episodes=span(map(len, comparison.groups.values())),
        causes=causes(failed_or_ended(records), {policy: len(group) for policy, group in comparison.groups.items()}),
        styles=styles,
    )
