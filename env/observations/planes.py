"""Planes of the whole map: ``channels``, any of its planes, the image of the thesis, and occupancy probabilities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError, did_you_mean
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.observations.base import Encoder, Views
from indoor_explorers.env.policies.view import Briefing, Mate, View
from indoor_explorers.env.search.frontiers import touches_unknown

#: The planes in the order of ``channels``. Each is full where its name holds and 0 elsewhere. ``mates`` marks the last
#: received cell of each teammate, with full minus the age in steps, at least 1; ``visited`` the cells that the UAV
#: itself has been in; ``frontier`` the known free cells with an unknown neighbour.
PLANES = ("unknown", "free", "obstacle", "self", "mates", "visited", "frontier")
SELF, MATES, VISITED, FRONTIER = (PLANES.index(plane) for plane in ("self", "mates", "visited", "frontier"))
#: A plane's full value in ``channels``.
FULL = 255
#: The thesis's grey levels of unknown, free and occupied cells (Table 3.1).
THESIS_LEVELS = np.array([0.0, 0.3, 0.5], np.float32)


@dataclass(frozen=True, kw_only=True)
class Channels:
    """Planes of the whole map, (C, H, W) uint8, 0 to 255."""

    planes: Sequence[str] = PLANES
    """Which of :data:`PLANES`, in which order."""

    def __post_init__(self) -> None:
        codes_of(self.planes)

    def __call__(self, briefing: Briefing) -> ChannelsEncoder:
        """Make the encoder of one UAV."""
        return ChannelsEncoder(self, briefing)


class ChannelsEncoder(Encoder):
    """Encode :class:`Channels`."""

    stateless = True

    def __init__(self, factory: Channels, briefing: Briefing) -> None:
        self.space = Box(0, FULL, (len(factory.planes), *briefing.shape), np.uint8)
        self.planes = factory.planes
        self._codes = codes_of(factory.planes)
        self._mates = np.flatnonzero(self._codes == MATES).tolist()

    def encode(self, view: View, out: NDArray[np.uint8]) -> None:
        """Paint the planes of one view into ``out`` (C, H, W)."""
        paint(view.belief, view.visited, view.cell[0], view.cell[1], self._codes, out)
        for k in self._mates:
            for mate in view.mates:
                out[k][mate.cell] = max(out[k][mate.cell], freshness(mate))

    def encode_batch(self, views: Views, out: NDArray[np.uint8]) -> None:
        """Paint the planes of single UAVs into ``out`` (B, C, H, W)."""
        _paint_all(views.belief, views.visited, views.cell, self._codes, out)


@dataclass(frozen=True)
class ThesisImage:
    """One (H, W) float32 image: 0 unknown, 0.3 free, 0.5 obstacle, UAVs by number + 1 (Table 3.1).

    Teammates are drawn in their last received cells; the UAV itself is drawn last.
    """

    def __call__(self, briefing: Briefing) -> ThesisEncoder:
        """Make the encoder of one UAV."""
        return ThesisEncoder(briefing)


class ThesisEncoder(Encoder):
    """Encode :class:`ThesisImage`."""

    stateless = True

    def __init__(self, briefing: Briefing) -> None:
        self.space = Box(0.0, float(briefing.team), briefing.shape, np.float32)
        self._own = briefing.agent + 1

    def encode(self, view: View, out: NDArray[np.float32]) -> None:
        """Paint one view into ``out`` (H, W)."""
        THESIS_LEVELS.take(view.belief, out=out, mode="clip")
        for mate in view.mates:
            out[mate.cell] = mate.agent + 1
        out[view.cell] = self._own

    def encode_batch(self, views: Views, out: NDArray[np.float32]) -> None:
        """Paint the views of single UAVs into ``out`` (B, H, W)."""
        THESIS_LEVELS.take(views.belief, out=out, mode="clip")
        out[np.arange(len(views.cell)), views.cell[:, 0], views.cell[:, 1]] = self._own


@dataclass(frozen=True)
class Occupancy:
    """The probability that each cell is occupied, (1, H, W) float32: see :attr:`View.occupancy`."""

    def __call__(self, briefing: Briefing) -> OccupancyEncoder:
        """Make the encoder of one UAV."""
        return OccupancyEncoder(briefing)


class OccupancyEncoder(Encoder):
    """Encode :class:`Occupancy`."""

    stateless = True

    def __init__(self, briefing: Briefing) -> None:
        self.space = Box(0.0, 1.0, (1, *briefing.shape), np.float32)

    def encode(self, view: View, out: NDArray[np.float32]) -> None:
        """Write one view's probabilities into ``out`` (1, H, W)."""
        out[0] = view.occupancy


def codes_of(planes: Sequence[str]) -> NDArray[np.int64]:
    """Return the (C,) numbers of planes in :data:`PLANES`; raise :class:`InputError` for none or an unknown one."""
    if isinstance(planes, str) or not planes:
        raise InputError(f"expected a sequence of planes such as ('free', 'self'), got {planes!r}")
    for plane in planes:
        if plane not in PLANES:
            raise InputError(f"unknown plane {plane!r}{did_you_mean(plane, PLANES)}")
    return np.array([PLANES.index(plane) for plane in planes])


def freshness(mate: Mate) -> int:
    """Return the value of a teammate's mark: :data:`FULL` minus the age of its last position, at least 1."""
    return max(FULL - mate.age, 1)


@kernel()
def paint(belief: np.ndarray, visited: np.ndarray, row: int, col: int, codes: np.ndarray, out: np.ndarray) -> None:
    """Fill ``out`` (C, H, W) uint8 with the planes ``codes`` (C,); those of teammates are zero."""
    height, width = belief.shape
    for k in range(codes.shape[0]):
        code, plane = codes[k], out[k]
        if code in (SELF, MATES):
            plane[:] = 0
        elif code == VISITED:
            for r in range(height):
                for c in range(width):
                    plane[r, c] = FULL if visited[r, c] else 0
        elif code == FRONTIER:
            for r in range(height):
                for c in range(width):
                    plane[r, c] = FULL if belief[r, c] == FREE and touches_unknown(belief, r, c) else 0
        else:
            for r in range(height):
                for c in range(width):
                    plane[r, c] = FULL if belief[r, c] == code else 0
        if code == SELF:
            plane[row, col] = FULL


@kernel()
def _paint_all(belief: np.ndarray, visited: np.ndarray, cell: np.ndarray, codes: np.ndarray, out: np.ndarray) -> None:
    for b in range(belief.shape[0]):
        paint(belief[b], visited[b], cell[b, 0], cell[b, 1], codes, out[b])
