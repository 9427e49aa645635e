"""The whole map at a coarse resolution: a grid of zones of fixed shape, around the UAV or over the map.

Zones are those of adaptive average pooling: zone i of n along an axis of L cells reaches from floor(i L / n) to
ceil((i + 1) L / n). Neighbours share a row of cells where n does not divide L, and zones of a map smaller than the grid
are single cells. Around the UAV, L is 2 H - 1 (2 W - 1), which contains the map for any position of the UAV (as in
Theile et al. 2020, arXiv:2010.06917).
"""

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
from indoor_explorers.env.observations.planes import FULL, MATES, SELF, codes_of, freshness, paint
from indoor_explorers.env.policies.view import Briefing, View

#: Planes of a coarse map unless others are asked for.
SHARES = ("unknown", "free", "frontier")


@dataclass(frozen=True, kw_only=True)
class Coarse:
    """The mean of each plane in each zone, (C, zones, zones) float32, 0 to 1.

    Cells off the map are obstacles. ``self`` and ``mates`` mark the UAVs' zones with their full value instead of a
    share; teammates fade with the age of their last received position.
    """

    zones: int = 12
    """Zones along a side."""
    planes: Sequence[str] = SHARES
    """Which of :data:`indoor_explorers.env.observations.PLANES`, in which order."""
    centred: bool = True
    """Whether the zones lie around the UAV; else they lie over the map."""

    def __post_init__(self) -> None:
        if not isinstance(self.zones, int) or self.zones < 1:
            raise InputError(f"expected zones to be a number from 1 such as 12, got {self.zones!r}")
        codes_of(self.planes)

    def __call__(self, briefing: Briefing) -> CoarseEncoder:
        """Make the encoder of one UAV."""
        return CoarseEncoder(self)


class CoarseEncoder(Encoder):
    """Encode a :class:`Coarse` map."""

    stateless = True

    def __init__(self, factory: Coarse) -> None:
        self.space = Box(0.0, 1.0, (len(factory.planes), factory.zones, factory.zones), np.float32)
        self._centred = factory.centred
        self._codes = codes_of(factory.planes)
        self._mates = np.flatnonzero(self._codes == MATES).tolist()

    def encode(self, view: View, out: NDArray[np.float32]) -> None:
        """Pool one view into ``out`` (C, zones, zones)."""
        row, col = view.cell
        _pool(view.belief, view.visited, row, col, self._centred, self._codes, out)
        if self._mates and view.mates:
            height, width = view.belief.shape
            rows, cols = (_edges(out.shape[1], *axis, self._centred) for axis in ((height, row), (width, col)))
            for k in self._mates:
                for mate in view.mates:
                    _mark(rows, cols, *mate.cell, freshness(mate) / FULL, out[k])

    def encode_batch(self, views: Views, out: NDArray[np.float32]) -> None:
        """Pool the views of single UAVs into ``out`` (B, C, zones, zones)."""
        _pool_all(views.belief, views.visited, views.cell, self._centred, self._codes, out)


@kernel()
def _edges(zones: int, cells: int, at: int, centred: bool) -> np.ndarray:
    """Return (zones, 2): the first cell of each zone of an axis of ``cells`` cells, and the one after its last."""
    span, first = (2 * cells - 1, at - cells + 1) if centred else (cells, 0)
    edges = np.empty((zones, 2), np.int64)
    for i in range(zones):
        edges[i, 0] = first + i * span // zones
        edges[i, 1] = first + ((i + 1) * span + zones - 1) // zones
    return edges


@kernel(error_model="numpy")
def _pool(
    belief: np.ndarray, visited: np.ndarray, row: int, col: int, centred: bool, codes: np.ndarray, out: np.ndarray
) -> None:
    """Fill ``out`` (C, Z, Z) float32 with the means of the planes ``codes`` (C,); those of teammates are zero."""
    height, width = belief.shape
    rows, cols = _edges(out.shape[1], height, row, centred), _edges(out.shape[2], width, col, centred)
    painted = np.empty((codes.shape[0], height, width), np.uint8)
    paint(belief, visited, row, col, codes, painted)
    column = np.empty(width, np.int32)
    for k in range(codes.shape[0]):
        outside = FULL if codes[k] == OCCUPIED else 0
        for i in range(out.shape[1]):
            top, bottom = max(rows[i, 0], 0), min(rows[i, 1], height)
            if top >= bottom:
                out[k, i] = outside / FULL
                continue
            column[:] = 0
            for r in range(top, bottom):
                cells = painted[k, r]
                for c in range(width):
                    column[c] += cells[c]
            for j in range(out.shape[2]):
                left, right = max(cols[j, 0], 0), min(cols[j, 1], width)
                area = (rows[i, 1] - rows[i, 0]) * (cols[j, 1] - cols[j, 0])
                total = outside * (area - (bottom - top) * max(right - left, 0))
                for c in range(left, right):
                    total += column[c]
                out[k, i, j] = total / (FULL * area)
        if codes[k] == SELF:
            out[k] = np.ceil(out[k])


@kernel()
def _mark(rows: np.ndarray, cols: np.ndarray, row: int, col: int, level: float, plane: np.ndarray) -> None:
    """Raise to ``level`` the zones of ``plane`` (Z, Z) that hold the cell (row, col)."""
    for i in range(plane.shape[0]):
        for j in range(plane.shape[1]):
            if rows[i, 0] <= row < rows[i, 1] and cols[j, 0] <= col < cols[j, 1]:
                plane[i, j] = max(plane[i, j], level)


@kernel()
def _pool_all(
    belief: np.ndarray, visited: np.ndarray, cell: np.ndarray, centred: bool, codes: np.ndarray, out: np.ndarray
) -> None:
    for b in range(belief.shape[0]):
        _pool(belief[b], visited[b], cell[b, 0], cell[b, 1], centred, codes, out[b])
