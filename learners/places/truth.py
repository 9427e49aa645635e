"""Features of the true map at a choice: inputs of the value networks in training, never of a network that flies.

The length of a flight depends on the map much more than on any choice. A value that knows the map removes this
variance from the returns; the rest depends on the chosen places (Pinto et al. 2018, "Asymmetric Actor Critic",
arXiv:1710.06542).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Distances, Mask
from indoor_explorers.env.grid.cells import UNKNOWN
from indoor_explorers.env.grid.levels import Levels
from indoor_explorers.learners.places.scene import LATENCY_OF_VIEWS, Scene
from indoor_explorers.planners.toolbox.frontiers.clusters import Clusters
from indoor_explorers.planners.toolbox.pockets.labels import true_pockets
from indoor_explorers.planners.toolbox.routing.min_latency import best_orders

#: Features of each place, and of the whole map.
TRUE_PLACE, TRUE_COMMON = 3, 10


class TrueMap(NamedTuple):
    """The true map of a flight, a plane where there are levels."""

    cells: Belief
    """(H, W) the map."""
    reachable: Mask
    """(H, W) bool, its free cells that count."""
    levels: Levels


class Truth(NamedTuple):
    """The true extent of the unexplored space, scaled to numbers around 1."""

    places: NDArray[np.float32]
    """(K, TRUE_PLACE): free cells behind each place, their share of those missing for 99 %, steps to the farthest."""
    common: NDArray[np.float32]
    """(TRUE_COMMON,): cells missing for 99 % and 90 %; unknown cells; blocks with any and with more than 1/8 of them,
    large blocks with any; tour length and waiting cost; summed depths of all pockets; places with a pocket behind."""


def truth_of(
    scene: Scene, clusters: Clusters, belief: Belief, true: TrueMap, field: Distances, lidar_range: float
) -> Truth:
    """Return the features of the true map at a scene of K places among frontier clusters.

    ``belief`` (H, W) uint8 is the known map, ``field`` (H, W) the UAV's steps through known free cells;
    ``lidar_range`` is in cells.
    """
    pockets = true_pockets(belief, true.cells, field, clusters, true.levels.rise)
    sizes, depths = pockets.sizes[scene.owner], pockets.depths[scene.owner]
    left = (belief == UNKNOWN) & true.reachable
    total, unknown = int(true.reachable.sum()), int(left.sum())
    seen_at_once, high = lidar_range ** (3 if true.levels.rise else 2), min(true.levels.number, 4)
    to_goal, to_most = (max(0.0, np.ceil(share * total) - (total - unknown)) for share in (0.99, 0.9))
    volume = true.levels.volume(left)
    small, large = (_blocks(volume, side) for side in (max(2, int(lidar_range // 2)), max(3, int(2 * lidar_range))))
    length, waiting = _tours(scene, sizes)
    common = [
        to_goal / seen_at_once,
        to_most / seen_at_once,
        np.log1p(unknown) / 6.0,
        (small > 0.0).sum() / 20.0 / high,
        (small > 0.125).sum() / 20.0 / high,
        (large > 0.0).sum() / 10.0 / high,
        length / 10.0,
        waiting / 40.0,
        pockets.depths[pockets.sizes > 0].sum() / lidar_range / 10.0,
        (sizes > 0).sum() / 12.0,
    ]
    places = [np.log1p(sizes) / 5.0, np.minimum(sizes / max(1.0, to_goal), 2.0), depths / lidar_range / 2.0]
    return Truth(np.stack(places, axis=1).astype(np.float32), np.array(common, np.float32))


def _blocks(cells: Mask, side: int) -> NDArray[np.float64]:
    """Return the share of ``cells`` (L, H, W) bool in each block of ``side`` cells a side, and as high as there are."""
    sides = min(side, len(cells)), side, side
    counts = [-(-length // block) for length, block in zip(cells.shape, sides, strict=True)]
    padded = np.zeros([count * block for count, block in zip(counts, sides, strict=True)], np.bool_)
    padded[tuple(map(slice, cells.shape))] = cells
    parts = padded.reshape([each for pair in zip(counts, sides, strict=True) for each in pair])
    return np.asarray(parts.mean(axis=(1, 3, 5)))


def _tours(scene: Scene, sizes: NDArray[np.float64]) -> tuple[float, float]:
    """Return the length of a short tour of the places with cells behind them, and its least cost with waiting.

    ``sizes`` (K,) are the cells behind each place; costs are those of
    :func:`~indoor_explorers.planners.toolbox.routing.min_latency.best_orders`, in lidar ranges.
    """
    some = np.flatnonzero(sizes > 0)
    if len(some) < 2:
        return 0.0, 0.0
    start, between = scene.steps[some], np.ascontiguousarray(scene.between[np.ix_(some, some)])
    length = best_orders(start, between, np.full(len(some), 1.0 / len(some)), 0.0)[0].min()
    waiting = best_orders(start, between, sizes[some] / sizes[some].sum(), LATENCY_OF_VIEWS)[0].min()
    return float(length), float(waiting)
