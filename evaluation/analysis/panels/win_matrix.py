"""Wins, ties and losses of every policy against every other, task by task."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from indoor_explorers.evaluation.analysis.panels.replay_links import replay_link
from indoor_explorers.evaluation.analysis.task_times import PairedTimes, TaskTimes
from indoor_explorers.evaluation.drawing.formatting import EN_DASH, counted, fixed
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.statistics import WinTieLoss, win_tie_loss


class WinCell(NamedTuple):
    """A cell of the matrix: the policy of the row against that of the column."""

    tally: WinTieLoss
    shade: int
    """Colour, from -4 for all lost to 4 for all won."""
    title: str
    replay: str
    """Link to the replay of the task on which the row's policy was furthest ahead."""

    @property
    def text(self) -> str:
        """The counts."""
        return EN_DASH.join(str(count) for count in self.tally)


def win_matrix(task_times: TaskTimes) -> list[tuple[str, list[WinCell | None]]]:
    """Return a row of cells for each policy, best first; None on the diagonal and where two policies share no task.

    Empty when there are fewer than two policies with a task in common.
    """
    names = task_times.policies
    rows = [(name, [None if other == name else _duel(task_times, name, other) for other in names]) for name in names]
    return rows if any(cell for _, cells in rows for cell in cells) else []


def _duel(task_times: TaskTimes, policy: str, other: str) -> WinCell | None:
    pair = task_times.pair(policy, other)
    if not pair.tasks:
        return None
    tally = win_tie_loss(pair.ours, pair.theirs)
    score = (tally.wins - tally.losses) / len(pair.tasks)
    return WinCell(
        tally, round(4 * score), _text(policy, other, tally, pair), replay_link(policy, _furthest_ahead(pair))
    )


def _text(policy: str, other: str, tally: WinTieLoss, pair: PairedTimes) -> str:
    ahead = pair.theirs - pair.ours
    return (
        f"{policy} against {other}: fewer steps on {tally.wins} of {counted(len(pair.tasks), 'task')}, "
        f"equal on {tally.ties}, more on {tally.losses}; furthest ahead by {fixed(float(ahead.max()), 0)} steps"
    )


def _furthest_ahead(pair: PairedTimes) -> Task:
    return pair.tasks[int(np.argmax(pair.theirs - pair.ours))]
