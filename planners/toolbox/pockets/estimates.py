"""Estimates of how much unknown free space is behind each frontier cluster, from one UAV's map.

A small network (:mod:`.network`) looks at the map around a cluster (:mod:`.features`) and estimates the
probability of more than t unknown free cells behind it, for several t. Planners and learners use the same estimates.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.policies.view import Briefing
from indoor_explorers.planners.toolbox.frontiers.clusters import Clusters
from indoor_explorers.planners.toolbox.networks.weights_file import (
    optional_weights_path,
    read_once,
    read_weights_file,
    weights_path,
)
from indoor_explorers.planners.toolbox.pockets.features import COARSE_LAYERS, LEVELS, PLAIN, SIDE, Kind, pictures
from indoor_explorers.planners.toolbox.pockets.network import (
    OUTPUTS,
    THRESHOLDS,
    NetworkWeights,
    outputs,
    shapes,
    weights_from,
)

#: The weights that ship: for plain maps, and for maps of several levels.
SHIPPED = Path(__file__).parent / "weights" / "pockets.safetensors"
SHIPPED_LEVELS = SHIPPED.with_name("pockets-levels.safetensors")
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


@read_once
def _read(path: Path) -> tuple[Kind, NetworkWeights]:
    """Return the kind of maps of a file's network, which its metadata tell, and its weights."""
    file = read_weights_file(path, "the pocket network")
    kind = LEVELS if file.about.get("levels") else PLAIN
    return kind, weights_from(file.checked(shapes(kind)))


def load_weights(path: Path, kind: Kind = PLAIN) -> NetworkWeights:
    """Return the weights of a network for maps of a ``kind``; a process reads a file once, and again when it changes.

    Raises:
        InputError: the file is missing, or holds another network or one for maps of the other kind.

    """
    found, weights = _read(path)
    if found != kind:
        told = {PLAIN: "plain maps", LEVELS: "maps of several levels"}
        raise InputError(
            f"{path}: expected estimates for {told[kind]}, got those for {told[found]}; pocket_weights are for plain "
            "maps, level_weights, from a training with levels=true, for the others"
        )
    return weights


class EstimateFiles(NamedTuple):
    """The files of the weights of a policy's estimates."""

    plain: Path = SHIPPED
    """For plain maps."""
    levels: Path | None = None
    """For maps of several levels; None where there are to be no estimates there."""

    @classmethod
    def named(cls, pocket_weights: str | None = None, level_weights: str | None = None) -> EstimateFiles:
        """Return the files that the parameters of a policy, or the settings of a training, name.

        Raises:
            InputError: one of them is missing, or not a file of the network for such maps.

        """
        plain = weights_path(pocket_weights, SHIPPED, NAME)
        levels = optional_weights_path(level_weights, SHIPPED_LEVELS, NAME)
        load_weights(plain)
        if levels is not None:
            load_weights(levels, LEVELS)
        return cls(plain, levels)

    def estimator(self, briefing: Briefing, changed: int = CHANGED) -> PocketEstimator | None:
        """Return the estimator for one UAV's map; None where there are to be no estimates.

        ``changed`` are the cells that may have changed for an estimate to be kept, see :class:`PocketEstimator`.
        """
        path = self.plain if briefing.rise == 0 else self.levels
        if path is None:
            return None
        elevation = briefing.scenario.lidar.elevation
        return PocketEstimator(
            briefing.lidar_range, changed=changed, path=path, rise=briefing.rise, elevation=elevation
        )


#: Those of the parameters' defaults.
DEFAULT_FILES = EstimateFiles()


class PocketEstimator:
    """Estimate the pockets behind the clusters of one UAV's map; estimates of unchanged surroundings are reused.

    Args:
        lidar_range: Lidar range in cells.
        changed: Cells of the coarse picture that may have changed for an estimate to be kept; the fine one must be the
            same. With 0, UAVs with the same map have the same estimates, whatever they have seen before.
        path: File of the network's weights.
        rise: That of the map where it has levels, see :mod:`indoor_explorers.env.grid.levels`; 0 for a plain map.
        elevation: Degrees that the lidar looks up and down, where there are levels.

    """

    def __init__(
        self,
        lidar_range: float,
        *,
        changed: int = CHANGED,
        path: Path = SHIPPED,
        rise: int = 0,
        elevation: float = 90.0,
    ) -> None:
        self._range, self._changed = float(lidar_range), changed
        self._rise, self._elevation = rise, elevation
        kind = LEVELS if rise > 0 else PLAIN
        self._weights = load_weights(path, kind)
        self._kept: dict[bytes, int] = {}
        self._coarse = np.empty((0, kind.levels * COARSE_LAYERS, SIDE, SIDE), np.uint8)
        self._found = np.empty((0, OUTPUTS), np.float32)

    def estimate(self, belief: Belief, clusters: Clusters) -> PocketEstimates:
        """Return the estimates for K clusters of a (H, W) belief."""
        seen = pictures(belief, clusters, self._range, self._rise, self._elevation)
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
