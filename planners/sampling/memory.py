"""Viewpoints found by random trees: cells with unknown cells in view, kept as long as they have a gain."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.sampling.rrt_nbv import TreePolicy
from indoor_explorers.planners.sampling.samples import box_around, known_cells, tree_samples
from indoor_explorers.planners.sampling.segments import entries
from indoor_explorers.planners.sampling.trees import grow_tree
from indoor_explorers.planners.toolbox.information.view_gain import WeightedGains

#: Most viewpoints that are evaluated at a time: the nearest ones.
JUDGED = 256


def tree_cells(
    view: View, squares: Iterable[tuple[float, int]], bias: float, edge: float, rng: np.random.Generator
) -> NDArray[np.int32]:
    """Grow a tree from the UAV; return its known free cells, and those where it enters unknown space, flat.

    Each of the ``squares`` around the UAV is given by half its side in cells and its number of samples; a share
    ``bias`` of them is drawn from unknown cells next to known free ones. ``edge`` is the longest edge in cells.
    """
    drawn = []
    for half, count in squares:
        low, high = box_around(view.cell, half, view.belief.shape)
        drawn.append(tree_samples(view.belief, low, high, count, bias, rng))
    tree = grow_tree(view.belief, (view.cell[0] + 0.5, view.cell[1] + 0.5), np.concatenate(drawn), edge)
    cells = known_cells(view.belief, tree.vertices)
    return np.concatenate([cells[cells >= 0], entries(view.belief, *tree)])


class ViewpointMemory:
    """The viewpoints that one UAV's trees have found."""

    def __init__(self, briefing: Briefing, policy: TreePolicy) -> None:
        self._policy = policy
        self._rng = briefing.rng
        self._gains = WeightedGains(briefing.shape, briefing.lidar_range, policy.decay_length, policy.isolation)
        self._cells = np.empty(0, np.int32)

    def grow(self, view: View, *squares: tuple[float, int]) -> None:
        """Add the viewpoints of a tree with samples from squares around the UAV (:func:`tree_cells`)."""
        found = tree_cells(view, squares, self._policy.bias, self._policy.edge, self._rng)
        self._cells = np.union1d(self._cells, found)

    def recalled(self, view: View, steps: NDArray[np.int32]) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
        """Return the nearest viewpoints, (K,) flat cells, and their gains, (K,).

        ``steps`` (H*W,) are the path lengths. Unreachable viewpoints and those without a gain are removed.
        """
        cells = self._cells[(steps[self._cells] < UNREACHABLE) & ~view.visited.ravel()[self._cells]]
        cells = cells[np.argsort(steps[cells], kind="stable")]
        gains = self._gains.at(view.belief, cells[:JUDGED])
        good = cells[:JUDGED][gains > 0.0]
        self._cells = np.concatenate([good, cells[JUDGED:]])
        return good, gains[gains > 0.0]
