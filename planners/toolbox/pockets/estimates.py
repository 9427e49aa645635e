"""Estimates of how much unknown free space is behind each frontier cluster, from one UAV's map.

A small network (:mod:`.network`) looks at the map around a cluster (:mod:`.features`) and estimates the
probability of more than t unknown free cells behind it, for several t. Planners and learners use the same estimates.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.planners.toolbox.frontiers.clusters import Clusters
from indoor_explorers.planners.toolbox.networks.weights_file import read_once, read_weights_file, weights_path
from indoor_explorers.planners.toolbox.pockets.features import COARSE_LAYERS, SIDE, pictures
from indoor_explorers.planners.toolbox.pockets.network import (
    OUTPUTS,
    THRESHOLDS,
    NetworkWeights,
    outputs,
    shapes,
    weights_from,
)

#: The weights that ship.
SHIPPED = Path(__file__).parent / "weights" / "pockets.safetensors"
#: The file of the weights in the folder of a training.
NAME = "pockets.safetensors"
#: Cells of the coarse picture that may have changed for an estimate to be kept.
CHANGED = 60
#: Unknown free cells that are expected behind a cluster beyond the largest threshold, if that is exceeded.
BEYOND = 400.0


class PocketEstimates(NamedTuple):
    """Estimates for K clusters."""

    tails: NDArray[np.float64]
    """(K, T) probability of more than ``THRESHOLDS[t]`` unknown free cells; falls along each line."""
    sizes: NDArray[np.float64]
    """(K,) expected number of unknown free cells."""
    depths: NDArray[np.float64]
    """(K,) expected steps from the cluster to the farthest of them, if there are any."""


def mean_weights() -> NDArray[np.float64]:
    """Return the weights (T,) of tail probabilities in the expected size, linear in log(1 + t) between thresholds."""
    places, cells = np.log1p(THRESHOLDS), np.log1p(np.arange(THRESHOLDS[-1]))
    weights = np.array([np.interp(cells, places, unit).sum() for unit in np.eye(len(THRESHOLDS))])
    weights[-1] += BEYOND
    return weights


_MEAN = mean_weights()


def estimates_from(found: NDArray[np.float32]) -> PocketEstimates:
    """Return the estimates from the network's outputs (K, OUTPUTS)."""
    tails = 1.0 / (1.0 + np.exp(-found[:, :-1].astype(np.float64)))
    tails = np.minimum.accumulate(tails, axis=1)
    depths = np.expm1(np.clip(found[:, -1], 0.0, 10.0).astype(np.float64))
    return PocketEstimates(tails, tails @ _MEAN, depths)


def pocket_path(given: str | None) -> Path:
    """Return the path of weights: ``given``, or the file in it if it is a training's folder; None: the shipped ones."""
    return weights_path(given, SHIPPED, NAME)


@read_once
def load_weights(path: Path) -> NetworkWeights:
    """Return the network's weights from a file; a process reads it once, and again when it changes.

    Raises:
        InputError: the file is missing or holds another network.

    """
    return weights_from(read_weights_file(path, "the pocket network").checked(shapes()))


class PocketEstimator:
    """Estimate the pockets behind the clusters of one UAV's map; estimates of unchanged surroundings are reused.

    Args:
        lidar_range: Lidar range in cells.
        changed: Cells of the coarse picture that may have changed for an estimate to be kept; the fine one must be the
            same. With 0, UAVs with the same map have the same estimates, whatever they have seen before.
        path: File of the network's weights.

    """

    def __init__(self, lidar_range: float, *, changed: int = CHANGED, path: Path = SHIPPED) -> None:
        self._range, self._changed = float(lidar_range), changed
        self._weights = load_weights(path)
        self._kept: dict[bytes, int] = {}
        self._coarse = np.empty((0, COARSE_LAYERS, SIDE, SIDE), np.uint8)
        self._found = np.empty((0, OUTPUTS), np.float32)

    def estimate(self, belief: Belief, clusters: Clusters) -> PocketEstimates:
        """Return the estimates for K clusters of a (H, W) belief."""
        seen = pictures(belief, clusters, self._range)
        names = [picture.tobytes() for picture in seen.fine]
        before = np.array([self._kept.get(name, -1) for name in names], np.int64)
        is_kept = _are_alike(seen.coarse, self._coarse, before, self._changed)
        kept, new = np.flatnonzero(is_kept), np.flatnonzero(~is_kept)
        found, coarse = np.empty((clusters.size, OUTPUTS), np.float32), seen.coarse
        found[kept], coarse[kept] = self._found[before[kept]], self._coarse[before[kept]]
        if len(new):
            found[new] = outputs(seen.fine[new], coarse[new], seen.numbers[new], self._weights)
        self._kept = {names[k]: k for k in (*kept.tolist(), *new.tolist())}
        self._coarse, self._found = coarse, found
        return estimates_from(found)


@kernel()
def _are_alike(coarse: np.ndarray, before: np.ndarray, numbers: np.ndarray, most: int) -> np.ndarray:
    """Return which coarse pictures (K, layers, SIDE, SIDE) differ by at most ``most`` cells from previous ones, (K,).

    ``numbers`` (K,) are the places of the previous pictures in ``before``, -1 where there is none.
    """
    alike = np.zeros(numbers.shape[0], np.bool_)
    for k in range(numbers.shape[0]):
        if numbers[k] >= 0:
            new, old, changed = coarse[k].ravel(), before[numbers[k]].ravel(), np.int64(0)
            for place in range(new.shape[0]):
                changed += abs(np.int64(new[place]) - np.int64(old[place]))
            alike[k] = changed <= most
    return alike
