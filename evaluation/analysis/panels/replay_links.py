"""Links from cells and rows of panels to the replay of an episode."""

from __future__ import annotations

import json
from dataclasses import dataclass

from indoor_explorers.evaluation.drawing.table import Cell
from indoor_explorers.evaluation.harness.experiment.experiment import Task


@dataclass(frozen=True)
class ReplayCell(Cell):
    """A cell that opens a replay."""

    replay: str = ""


def replay_link(policy: str, task: Task) -> str:
    """Return the value of a ``data-replay`` attribute: the policy and the task, by map and seed, as JSON."""
    return json.dumps({"policy": policy, "task": [task.map_index, task.seed]}, ensure_ascii=False)
