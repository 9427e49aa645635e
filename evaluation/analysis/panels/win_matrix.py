"""Wins, ties and losses of every policy against every other, task by task."""

from __future__ import annotations

import numpy as np

from indoor_explorers.evaluation.analysis.panels.replay_links import ReplayCell, replay_link
from indoor_explorers.evaluation.analysis.task_times import PairedTimes, TaskTimes
from indoor_explorers.evaluation.drawing.formatting import EN_DASH, counted, fixed
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.statistics import WinTieLoss, win_tie_loss


def win_matrix(task_times: TaskTimes) -> list[tuple[str, list[ReplayCell]]]:
    """Return a row of cells for each policy, best first: wins, ties and losses against the policy of the column.

    Cells are shaded from -4 for all lost to 4 for all won, and replay the task on which the row's policy was furthest
    ahead; they are empty on the diagonal and where two policies share no task. There are no rows when there are fewer
    than two policies with a task in common.
    """
    names = task_times.policies
    cells = [[ReplayCell() if other == name else _duel(task_times, name, other) for other in names] for name in names]
    return list(zip(names, cells, strict=True)) if any(cell.text for row in cells for cell in row) else []


def _duel(task_times: TaskTimes, policy: str, other: str) -> ReplayCell:
    pair = task_times.pair(policy, other)
    if not pair.tasks:
        return ReplayCell()
    tally = win_tie_loss(pair.ours, pair.theirs)
    return ReplayCell(
        EN_DASH.join(map(str, tally)),
        shade=round(4 * (tally.wins - tally.losses) / len(pair.tasks)),
        title=_text(policy, other, tally, pair),
        replay=replay_link(policy, _furthest_ahead(pair)),
    )


def _text(policy: str, other: str, tally: WinTieLoss, pair: PairedTimes) -> str:
    ahead = pair.theirs - pair.ours
    return (
        f"{policy} against {other}: fewer steps on {tally.wins} of {counted(len(pair.tasks), 'task')}, "
        f"equal on {tally.ties}, more on {tally.losses}; furthest ahead by {fixed(float(ahead.max()), 0)} steps"
    )


def _furthest_ahead(pair: PairedTimes) -> Task:
    return pair.tasks[int(np.argmax(pair.theirs - pair.ours))]
