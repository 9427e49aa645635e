"""The frame stack: the latest scenes of each UAV as one network input (Mnih et al. 2015)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask


def stacked(scene: NDArray[np.uint8], scenes: NDArray[np.uint8], first: Mask) -> NDArray[np.uint8]:
    """Push new scenes (K, S) onto stacked ones (K, I), latest first; the ``first`` (K,) of an episode is repeated."""
    if scene.shape == scenes.shape:
        return scene
    frames = scenes.shape[1] // scene.shape[1]
    later = np.concatenate([scene, scenes[:, : -scene.shape[1]]], axis=1)
    return np.where(first[:, None], np.tile(scene, (1, frames)), later)
