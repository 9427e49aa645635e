"""Observation encoders: what ONE UAV knows, as an array for a learner.

An encoder reads a :class:`~indoor_explorers.env.view.View`, and the briefing that it was made with, and
nothing else. Encoders have names:

- ``channels``: all the planes of :data:`PLANES`, (6, H, W) uint8;
- some of them joined by ``+``, such as ``free+obstacle+self``, in that order;
- ``thesis``: the image of the thesis, (H, W) float32.

Anything that takes a briefing and returns an :class:`Encoder` serves in place of a name.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from indoor_explorers.env.compiled import kernel
from indoor_explorers.env.errors import InputError, did_you_mean
from indoor_explorers.env.grid import frontier_mask
from indoor_explorers.env.view import Briefing, View

#: Planes of ``channels`` in their order. Each is 255 where its name holds and 0 elsewhere; ``mates`` marks where
#: each teammate was last heard with 255 less the age of that news in steps, at least 1.
PLANES = ("unknown", "free", "obstacle", "self", "mates", "frontier")
_SELF, _FRONTIER = PLANES.index("self"), PLANES.index("frontier")
#: What the thesis paints unknown, free and occupied cells with (Table 3.1).
THESIS_LEVELS = np.array([0.0, 0.3, 0.5], np.float32)


class Encoder(ABC):
    """Turn one UAV's view into an array."""

    #: What :meth:`encode` fills; the same object for the encoder's whole life.
    space: Box

    @abstractmethod
    def encode(self, view: View, out: NDArray[Any]) -> None:
        """Overwrite all of ``out``, an array of the space's shape and dtype."""

    def observation(self, view: View) -> NDArray[Any]:
        """Return a new array that holds the encoded view."""
        out = np.empty(self.space.shape, self.space.dtype)
        self.encode(view, out)
        return out


class BatchEncoder(Encoder):
    """An encoder that can also encode many UAVs that fly alone, in many episodes, at once."""

    @abstractmethod
    def encode_batch(self, belief: NDArray[np.uint8], cell: NDArray[np.int64], out: NDArray[Any]) -> None:
        """Overwrite ``out`` (B, *space) from beliefs (B, H, W) and own cells (B, 2)."""


#: How an observation is chosen: by name, or by what makes an encoder for a briefing.
Observation: TypeAlias = str | Callable[[Briefing], Encoder]


class Channels(BatchEncoder):
    """Stack planes of :data:`PLANES` to a (C, H, W) uint8 image."""

    def __init__(self, briefing: Briefing, planes: Sequence[str] = PLANES) -> None:
        self.planes = tuple(planes)
        self.space = Box(0, 255, (len(planes), *briefing.shape), np.uint8)
        self._codes = np.array([PLANES.index(plane) for plane in planes])
        self._mates = [k for k, plane in enumerate(planes) if plane == "mates"]

    def encode(self, view: View, out: NDArray[np.uint8]) -> None:
        """Paint the planes of one view."""
        _paint(view.belief, view.cell[0], view.cell[1], self._codes, out)
        for k in self._mates:
            for mate in view.mates:
                out[k][mate.cell] = max(out[k][mate.cell], 255 - mate.age, 1)

    def encode_batch(self, belief: NDArray[np.uint8], cell: NDArray[np.int64], out: NDArray[np.uint8]) -> None:
        """Paint the planes of many UAVs that fly alone."""
        _paint_all(belief, cell, self._codes, out)


class ThesisImage(BatchEncoder):
    """Paint one (H, W) float32 image: 0 unknown, 0.3 free, 0.5 obstacle, UAVs by number + 1 (Table 3.1).

    Teammates stand where they were last heard; the UAV itself is painted last.
    """

    def __init__(self, briefing: Briefing) -> None:
        self.space = Box(0.0, float(briefing.team), briefing.shape, np.float32)
        self._own = briefing.agent + 1

    def encode(self, view: View, out: NDArray[np.float32]) -> None:
        """Paint one view."""
        THESIS_LEVELS.take(view.belief, out=out, mode="clip")
        for mate in view.mates:
            out[mate.cell] = mate.agent + 1
        out[view.cell] = self._own

    def encode_batch(self, belief: NDArray[np.uint8], cell: NDArray[np.int64], out: NDArray[np.float32]) -> None:
        """Paint many UAVs that fly alone."""
        THESIS_LEVELS.take(belief, out=out, mode="clip")
        out[np.arange(len(cell)), cell[:, 0], cell[:, 1]] = self._own


def make_encoder(observation: Observation, briefing: Briefing) -> Encoder:
    """Return the encoder of that name, or what a given function makes, for one UAV.

    Raises:
        InputError: no encoder or plane has that name.

    """
    if not isinstance(observation, str):
        return observation(briefing)
    if observation == "thesis":
        return ThesisImage(briefing)
    if observation == "channels":
        return Channels(briefing)
    planes = observation.split("+")
    for plane in planes:
        if plane not in PLANES:
            known = PLANES if len(planes) > 1 else ("channels", "thesis", *PLANES)
            raise InputError(f"unknown observation {plane!r}{did_you_mean(plane, known)}")
    return Channels(briefing, planes)


@kernel()
def _paint(belief: np.ndarray, row: int, col: int, codes: np.ndarray, out: np.ndarray) -> None:
    """Fill planes ``out`` (C, H, W) uint8 of the kinds ``codes`` (C,), that of teammates with zeros."""
    height, width = belief.shape
    for k in range(codes.shape[0]):
        code, plane = codes[k], out[k]
        if code < _SELF:
            for r in range(height):
                for c in range(width):
                    plane[r, c] = 255 if belief[r, c] == code else 0
        elif code == _FRONTIER:
            plane[:] = frontier_mask(belief) * np.uint8(255)
        else:
            plane[:] = 0
            if code == _SELF:
                plane[row, col] = 255


@kernel()
def _paint_all(belief: np.ndarray, cell: np.ndarray, codes: np.ndarray, out: np.ndarray) -> None:
    for b in range(belief.shape[0]):
        _paint(belief[b], cell[b, 0], cell[b, 1], codes, out[b])
