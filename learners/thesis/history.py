"""The training curves that the thesis plots: each episode's score, and the mean coverage by step.

Training episodes include random moves. As in the thesis, the mean coverage at a step is over the episodes that were
still flying: one that ended earlier, by a crash or at the goal, is not in it.
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
    """Record the training episodes of ``environments`` parallel environments."""

    def __init__(self, environments: int) -> None:
        self.running = np.zeros(environments)
        """(B,) sum of the first UAV's rewards in the current episodes."""
        self.rows: list[tuple[float, int, float, int]] = []
        """Score, steps, coverage and the first UAV's :class:`End` of every finished episode."""
        self.covered = np.zeros(0)
        """(T,) coverage by step, summed over the episodes that were flying."""
        self.flown = np.zeros(0, np.int64)
        """(T,) number of these episodes."""

    def record_step(self, reward: NDArray[np.float64], step: NDArray[np.int64], coverage: NDArray[np.float64]) -> None:
        """Record a step: (B,) the first UAV's rewards, the steps flown so far, and the coverage after them."""
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
        """Record finished ``episodes``; (B,) steps, coverage and the first UAV's end are those of all episodes."""
        for b in episodes.tolist():
            self.rows.append((float(self.running[b]), int(step[b]), float(coverage[b]), int(end[b])))
        self.running[episodes] = 0.0

    def write(self, path: Path, episodes: int) -> None:
        """Write the first ``episodes`` finished episodes as CSV."""
        with written_whole(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
            table = csv.writer(file)
            table.writerow(COLUMNS)
            for number, (score, steps, coverage, end) in enumerate(self.rows[:episodes], 1):
                table.writerow([number, f"{score:g}", steps, f"{coverage:.4f}", End(end).name.lower()])

    def by_step(self) -> list[float]:
        """Return the mean coverage after 1, 2, ... steps over the episodes that were flying."""
        return [round(float(share), 4) for share in self.covered / np.maximum(self.flown, 1)]

    def tensors(self) -> dict[str, NDArray[Any]]:
        """Return everything that :meth:`restore` needs, by name."""
        rows = np.array(self.rows, np.float64).reshape(-1, 4)
        arrays = {"rows": rows, "running": self.running, "covered": self.covered, "flown": self.flown}
        return {f"history/{name}": array for name, array in arrays.items()}

    def restore(self, tensors: dict[str, NDArray[Any]]) -> None:
        """Restore the state that :meth:`tensors` returned."""
        rows = tensors["history/rows"].tolist()
        self.rows = [(score, int(steps), coverage, int(end)) for score, steps, coverage, end in rows]
        self.running = tensors["history/running"]
        self.covered, self.flown = tensors["history/covered"], tensors["history/flown"]


def _padded(values: NDArray[Any], size: int) -> NDArray[Any]:
    return np.pad(values, (0, size - len(values)))
