"""The knowledge of a UAV besides maps: a few numbers, the legal moves and the heading."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import UNKNOWN
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.observations.base import Encoder, Views
from indoor_explorers.env.policies.view import Briefing, View

#: The numbers of a status, in order: share of the map's cells that are known; share of the budget flown; own number
#: + 1 as a share of the team; share of the teammates linked now; own row and column as shares of the map's height and
#: width; and 1 for each of the five moves that is legal.
STATUS = ("known", "elapsed", "number", "linked", "row", "column", "down", "left", "up", "right", "stay")

#: The numbers that a status with the home base has after them: 1 where there is a base; rows downwards and columns to
#: the right from the UAV to it, 0.5 for none, 0 and 1 for the map's height and width; and steps since the last contact
#: with it as a share of the budget, 1 for never. Without a base all are 0.
BASE_STATUS = ("base", "base_down", "base_right", "base_age")


@dataclass(frozen=True)
class Status:
    """The numbers of :data:`STATUS`, (11,) float32, 0 to 1; with ``base`` those of :data:`BASE_STATUS` too, (15,)."""

    base: bool = False
    """Whether it includes the home base, also in scenarios without one."""

    def __call__(self, briefing: Briefing) -> StatusEncoder:
        """Make the encoder of one UAV."""
        return StatusEncoder(self, briefing)


class StatusEncoder(Encoder):
    """Encode a :class:`Status`; with ``base`` it stores the base's cell of this episode."""

    def __init__(self, factory: Status, briefing: Briefing) -> None:
        self.space = Box(0.0, 1.0, (len(STATUS) + factory.base * len(BASE_STATUS),), np.float32)
        self.stateless = not factory.base
        self._shape, self._base = briefing.shape, briefing.base
        self._number = (briefing.agent + 1) / briefing.team
        self._mates = max(briefing.team - 1, 1)

    def encode(self, view: View, out: NDArray[np.float32]) -> None:
        """Write one view's numbers into ``out`` (11,), or (15,) with the base."""
        linked = sum(mate.age == 0 for mate in view.mates) / self._mates if view.mates else 0.0
        elapsed = view.step / view.budget
        _fill(view.belief, view.cell[0], view.cell[1], view.legal, elapsed, self._number, linked, out)
        if not self.stateless:
            out[len(STATUS) :] = self._of_base(view)

    def begin(self, briefing: Briefing) -> None:
        """Store the base's cell."""
        self._base = briefing.base

    def _of_base(self, view: View) -> tuple[float, float, float, float]:
        """Return the numbers of :data:`BASE_STATUS`."""
        if self._base is None:
            return 0.0, 0.0, 0.0, 0.0
        down, right = ((base - own) / side for base, own, side in zip(self._base, view.cell, self._shape, strict=True))
        age = 1.0 if view.base_age is None else view.base_age / view.budget
        return 1.0, 0.5 + down / 2, 0.5 + right / 2, age

    def encode_batch(self, views: Views, out: NDArray[np.float32]) -> None:
        """Write the numbers of single UAVs into ``out`` (B, 11)."""
        _fill_all(views.belief, views.cell, views.legal, views.step / views.budget, self._number, out)


@dataclass(frozen=True)
class Legal:
    """The action mask, (5,) int8: 1 for the moves that end neither in a wall nor off the map.

    Where the lidar's field of view is limited it is (6,): UAVs may always turn.
    """

    def __call__(self, briefing: Briefing) -> LegalEncoder:
        """Make the encoder of one UAV."""
        return LegalEncoder(briefing)


class LegalEncoder(Encoder):
    """Encode :class:`Legal`."""

    stateless = True

    def __init__(self, briefing: Briefing) -> None:
        self.space = Box(0, 1, (briefing.scenario.actions,), np.int8)

    def encode(self, view: View, out: NDArray[np.int8]) -> None:
        """Write one view's legal actions into ``out`` (A,)."""
        out[: len(view.legal)] = view.legal
        out[len(view.legal) :] = 1

    def encode_batch(self, views: Views, out: NDArray[np.int8]) -> None:
        """Write the legal actions of single UAVs into ``out`` (B, A)."""
        moves = views.legal.shape[1]
        out[:, :moves] = views.legal
        out[:, moves:] = 1


@dataclass(frozen=True)
class Heading:
    """The direction that the UAV faces, (4,) float32: 1 for down, left, up or right; zeros where it sees all around."""

    def __call__(self, briefing: Briefing) -> HeadingEncoder:
        """Make the encoder of one UAV."""
        return HeadingEncoder()


class HeadingEncoder(Encoder):
    """Encode :class:`Heading`."""

    stateless = True

    def __init__(self) -> None:
        self.space = Box(0.0, 1.0, (4,), np.float32)

    def encode(self, view: View, out: NDArray[np.float32]) -> None:
        """Write one view's heading into ``out`` (4,)."""
        out[:] = 0.0
        if view.heading is not None:
            out[view.heading] = 1.0


@kernel()
def _fill(
    belief: np.ndarray,
    row: int,
    col: int,
    legal: np.ndarray,
    elapsed: float,
    number: float,
    linked: float,
    out: np.ndarray,
) -> None:
    height, width = belief.shape
    known = 0
    for r in range(height):
        for c in range(width):
            known += belief[r, c] != UNKNOWN
    out[0], out[1], out[2], out[3] = known / belief.size, elapsed, number, linked
    out[4], out[5] = (row + 0.5) / height, (col + 0.5) / width
    for action in range(5):
        out[6 + action] = legal[action]


@kernel()
def _fill_all(
    belief: np.ndarray, cell: np.ndarray, legal: np.ndarray, elapsed: np.ndarray, number: float, out: np.ndarray
) -> None:
    for b in range(belief.shape[0]):
        _fill(belief[b], cell[b, 0], cell[b, 1], legal[b], elapsed[b], number, 0.0, out[b])
