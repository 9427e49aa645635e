"""Estimates of how much unknown free space is behind each frontier cluster, from one UAV's map.

A small network (:mod:`.network`) looks at the map around a cluster (:mod:`.features`) and tells how likely more than t
unknown free cells are behind it, for several t. Planners and learners use the same estimates.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.search.clusters import Clusters
from indoor_explorers.env.search.pockets.features import pictures
from indoor_explorers.env.search.pockets.network import (
    OUTPUTS,
    THRESHOLDS,
    NetworkWeights,
    outputs,
    shapes,
    weights_from,
)
from indoor_explorers.env.tensors import read_tensors

#: The weights that ship.
SHIPPED = Path(__file__).parent / "weights" / "pockets.safetensors"
#: Cells of the coarse picture that may have changed for an estimate to be kept; the fine one must be the same.
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
    """Return the estimates that the network's outputs (K, OUTPUTS) stand for."""
    tails = 1.0 / (1.0 + np.exp(-found[:, :-1].astype(np.float64)))
    tails = np.minimum.accumulate(tails, axis=1)
    depths = np.expm1(np.clip(found[:, -1], 0.0, 10.0).astype(np.float64))
    return PocketEstimates(tails, tails @ _MEAN, depths)


@lru_cache(maxsize=4)
def load_weights(path: Path = SHIPPED) -> NetworkWeights:
    """Return the network's weights from a file.

    Raises :class:`InputError` where it is missing or holds another network.
    """
    found, _ = read_tensors(path, sum(4 * int(np.prod(shape)) for shape in shapes().values()) + 10_000)
    return weights_from(found)


class PocketEstimator:
    """Estimate the pockets behind the clusters of one UAV's map, step by step; what looks the same is kept."""

    def __init__(self, lidar_range: float, path: Path = SHIPPED) -> None:
        self._range = float(lidar_range)
        self._weights = load_weights(path)
        self._kept: dict[bytes, tuple[NDArray[np.uint8], NDArray[np.float32]]] = {}

    def estimate(self, belief: Belief, clusters: Clusters) -> PocketEstimates:
        """Return the estimates for K clusters of a (H, W) belief."""
        seen = pictures(belief, clusters, self._range)
        found = np.empty((clusters.size, OUTPUTS), np.float32)
        names = [picture.tobytes() for picture in seen.fine]
        new = [k for k, name in enumerate(names) if not self._is_kept(name, seen.coarse[k], found[k])]
        if new:
            found[new] = outputs(seen.fine[new], seen.coarse[new], seen.numbers[new], self._weights)
        before = self._kept
        self._kept = {name: before[name] for name in names if name in before}
        self._kept |= {names[k]: (seen.coarse[k], found[k].copy()) for k in new}
        return estimates_from(found)

    def _is_kept(self, name: bytes, coarse: NDArray[np.uint8], out: NDArray[np.float32]) -> bool:
        """Copy the outputs for a picture seen before, and tell whether there are any."""
        if name not in self._kept:
            return False
        before, found = self._kept[name]
        if np.abs(coarse.astype(np.int16) - before).sum() > CHANGED:
            return False
        out[:] = found
        return True
