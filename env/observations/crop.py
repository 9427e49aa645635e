"""The surroundings of the UAV: a square of planes with the UAV in the middle, of the same shape on any map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.cells import OCCUPIED
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.observations.base import Encoder, Views
from indoor_explorers.env.observations.planes import FULL, MATES, codes_of, freshness, paint
from indoor_explorers.env.policies.view import Briefing, View

SCALE = np.float32(1 / FULL)
#: Default planes of a crop; an unknown cell is neither free nor an obstacle.
NEARBY = ("free", "obstacle", "mates", "visited", "frontier")


@dataclass(frozen=True, kw_only=True)
class Crop:
    """Planes around the UAV, (C, side, side) float32, 0 to 1. Cells off the map are obstacles."""

    side: int = 15
    """Cells along a side; odd, so that the UAV is in the middle."""
    planes: Sequence[str] = NEARBY
    """Which of :data:`indoor_explorers.env.observations.PLANES`, in which order."""

    def __post_init__(self) -> None:
        if not isinstance(self.side, int) or self.side < 1 or self.side % 2 == 0:
            raise InputError(f"expected side to be an odd number of cells such as 15, got {self.side!r}")
        codes_of(self.planes)

    def __call__(self, briefing: Briefing) -> CropEncoder:
        """Make the encoder of one UAV."""
        return CropEncoder(self)


class CropEncoder(Encoder):
    """Encode a :class:`Crop`."""

    stateless = True

    def __init__(self, factory: Crop) -> None:
        self.space = Box(0.0, 1.0, (len(factory.planes), factory.side, factory.side), np.float32)
        self._side = factory.side
        self._codes = codes_of(factory.planes)
        self._mates = np.flatnonzero(self._codes == MATES).tolist()

    def encode(self, view: View, out: NDArray[np.float32]) -> None:
        """Crop one view into ``out`` (C, side, side)."""
        _crop(view.belief, view.visited, view.cell[0], view.cell[1], self._codes, out)
        for k in self._mates:
            for mate in view.mates:
                r, c = (mate.cell[axis] - view.cell[axis] + self._side // 2 for axis in (0, 1))
                if 0 <= r < self._side and 0 <= c < self._side:
                    out[k, r, c] = max(out[k, r, c], freshness(mate) / FULL)

    def encode_batch(self, views: Views, out: NDArray[np.float32]) -> None:
        """Crop the views of single UAVs into ``out`` (B, C, side, side)."""
        _crop_all(views.belief, views.visited, views.cell, self._codes, out)


@kernel()
def _crop(belief: np.ndarray, visited: np.ndarray, row: int, col: int, codes: np.ndarray, out: np.ndarray) -> None:
    """Fill planes ``out`` (C, S, S) float32 around (row, col); those of teammates are zero."""
    side = out.shape[1]
    top, left = row - side // 2, col - side // 2
    r0, c0 = max(top - 1, 0), max(left - 1, 0)  # one cell more on each side, which decides what is a frontier
    near = belief[r0 : top + side + 1, c0 : left + side + 1]
    painted = np.empty((codes.shape[0], *near.shape), np.uint8)
    paint(near, visited[r0 : top + side + 1, c0 : left + side + 1], row - r0, col - c0, codes, painted)
    first, last = max(top, 0), min(top + side, belief.shape[0])
    start, stop = max(left, 0), min(left + side, belief.shape[1])
    for k in range(codes.shape[0]):
        out[k] = 1 if codes[k] == OCCUPIED else 0
        for r in range(first, last):
            source, target = painted[k, r - r0, start - c0 : stop - c0], out[k, r - top, start - left : stop - left]
            for c in range(stop - start):
                target[c] = source[c] * SCALE


@kernel()
def _crop_all(belief: np.ndarray, visited: np.ndarray, cell: np.ndarray, codes: np.ndarray, out: np.ndarray) -> None:
    for b in range(belief.shape[0]):
        _crop(belief[b], visited[b], cell[b, 0], cell[b, 1], codes, out[b])
