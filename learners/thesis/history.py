"""What the thesis plots of a training: each episode's score, and how much was explored by which step.

These are episodes with exploration, and the coverage is the mean over those that still flew at a step, as the
thesis plots it: one that ended early, in a crash or at the goal, is in no later mean.
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.files import written_whole
from indoor_explorers.env.simulation.state import End

#: Columns of the table of episodes.
COLUMNS = ("episode", "score", "steps", "coverage", "end")


class History:
    """Record the training episodes of ``environments`` episodes flown side by side."""

    def __init__(self, environments: int) -> None:
        self.running = np.zeros(environments)
        """(B,) the first UAV's rewards in the episodes under way."""
        self.rows: list[tuple[float, int, float, int]] = []
        """Score, steps, coverage and the first UAV's :class:`End` of every episode that is over."""
        self.covered = np.zeros(0)
        """(T,) coverage by step, summed over the episodes that flew then."""
        self.flown = np.zeros(0, np.int64)
        """(T,) how many those were."""

    def record_step(self, reward: NDArray[np.float64], step: NDArray[np.int64], coverage: NDArray[np.float64]) -> None:
        """Record (B,) the first UAV's rewards, the steps flown by now, and the coverage after them."""
        self.running += reward
        size = max(len(self.flown), int(step.max()))
        self.covered = _padded(self.covered, size) + np.bincount(step - 1, coverage, size)
        self.flown = _padded(self.flown, size) + np.bincount(step - 1, minlength=size)

    def record_ends(
        self,
        episodes: NDArray[np.int64],
        step: NDArray[np.int64],
        coverage: NDArray[np.float64],
        end: NDArray[np.uint8],
    ) -> None:
        """Record episodes that are over: (B,) steps, coverage and the first UAV's end, of all of them."""
        for b in episodes.tolist():
            self.rows.append((float(self.running[b]), int(step[b]), float(coverage[b]), int(end[b])))
        self.running[episodes] = 0.0

    def write(self, path: Path, episodes: int) -> None:
        """Write the first ``episodes`` of them as CSV."""
        with written_whole(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
            table = csv.writer(file)
            table.writerow(COLUMNS)
            for number, (score, steps, coverage, end) in enumerate(self.rows[:episodes], 1):
                table.writerow([number, f"{score:g}", steps, f"{coverage:.4f}", End(end).name.lower()])

    def by_step(self) -> list[float]:
        """Return the mean coverage after 1, 2, ... steps, over the episodes that still flew."""
        return [round(float(share), 4) for share in self.covered / np.maximum(self.flown, 1)]

    def tensors(self) -> dict[str, NDArray[Any]]:
        """Return everything that :meth:`restore` needs, by name."""
        rows = np.array(self.rows, np.float64).reshape(-1, 4)
        return {"history/rows": rows, "history/running": self.running} | {
            "history/covered": self.covered,
            "history/flown": self.flown,
        }

    def restore(self, tensors: dict[str, NDArray[Any]]) -> None:
        """Go on exactly where :meth:`tensors` was taken."""
        self.rows = [
            (score, int(steps), part, int(end)) for score, steps, part, end in tensors["history/rows"].tolist()
        ]
        self.running = tensors["history/running"]
        self.covered, self.flown = tensors["history/covered"], tensors["history/flown"]


def _padded(values: NDArray[Any], size: int) -> NDArray[Any]:
    return np.pad(values, (0, size - len(values)))
