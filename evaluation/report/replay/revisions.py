"""Maps that can be wrong, for the replay: which cells begin or cease to be shown rightly, or wrongly, at each step."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import UNKNOWN, World
from indoor_explorers.evaluation.report.packing import Keyed, runs


class Revisions:
    """The changes of some (H * W,) masks over time; every mask is empty before the first step."""

    def __init__(self, size: int, masks: int) -> None:
        self._now = np.zeros((masks, size), np.bool_)
        self._steps: list[list[NDArray[np.int64]]] = [[] for _ in range(masks)]

    def add(self, masks: list[NDArray[np.bool_]]) -> None:
        """Note the masks after one step more."""
        for place, mask in enumerate(masks):
            self._steps[place].append(np.flatnonzero(self._now[place] != mask))
            self._now[place] = mask

    def by_frame(self, shown: NDArray[np.int64]) -> list[Keyed]:
        """Return for each mask the cells that changed since the frame before, as runs; frames are steps (F,)."""
        listed = np.arange(len(shown))
        return [self._runs(changes, shown, listed) for changes in self._steps]

    def _runs(self, changes: list[NDArray[np.int64]], shown: NDArray[np.int64], listed: NDArray[np.int64]) -> Keyed:
        lengths = [len(cells) for cells in changes]
        frames = np.repeat(np.searchsorted(shown, np.arange(len(changes))), lengths)
        size = self._now.shape[1]
        keys, times = np.unique(frames * size + np.concatenate(changes), return_counts=True)
        keys = keys[times % 2 == 1]  # what changed there and back between two frames did not change
        return runs(keys // size, keys % size, listed)


def masks_of(world: World) -> list[NDArray[np.bool_]]:
    """Return what the team's map shows rightly and wrongly in place 0, and what the base's map shows rightly."""
    state, truth = world.state, world.state.truth[0]
    team = state.union[0]
    masks = [team == truth, (team != truth) & (team != UNKNOWN)]
    return [mask.ravel() for mask in (*masks, *([state.base_belief[0] == truth] if world.scenario.base.exists else []))]
