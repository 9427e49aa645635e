"""The tour of one UAV through a small map: planned over cells, kept while it stands, planned anew as the map grows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.arrays import Belief
from indoor_explorers.env.grid import FREE, UNKNOWN
from indoor_explorers.planners.horizon.beam import Style, Terrain, shortest_tour
from indoor_explorers.planners.horizon.cellsets import Bits, around, hash_keys, packed, unpacked
from indoor_explorers.planners.horizon.prior import Prior
from indoor_explorers.planners.horizon.sights import Sights

#: Free cells that may be missing when everything is wanted, as an expected number.
CERTAINTY = 0.2


class Tours:
    """Plan tours that show the share ``goal`` of the free cells, first with a share ``spare`` of them left out."""

    def __init__(
        self, shape: tuple[int, int], lidar_range: float, prior: Prior, style: Style, goal: float, spare: float
    ) -> None:
        self.sights = Sights(shape, lidar_range)
        self._prior, self._style, self._goal, self._spare = prior, style, goal, spare
        self._around, self._keys = around(shape), hash_keys(2 * shape[0] * shape[1])
        self._tour: list[int] = []
        self._finishes = False

    @property
    def length(self) -> int:
        """Steps that the tour still has."""
        return len(self._tour)

    def following(self, cell: int) -> int | None:
        """Return the next cell of the tour of a UAV in a flat cell; None when there is none."""
        if self._tour and self._tour[0] == cell:
            self._tour = self._tour[1:]
        stands = self._tour and self._tour[0] in self.sights.passages[cell]
        return self._tour[0] if stands else None

    def plan(self, belief: Belief, cell: int, share: NDArray[np.float64] | None = None) -> None:
        """Plan a tour from a flat cell, or keep the old one if the new one is no shorter.

        ``share`` (C,) is how much of each cell is this UAV's to see, 1 unless a teammate is to see it.
        """
        self.sights.update(belief)
        self.following(cell)
        unseen = packed(belief == UNKNOWN) & self.sights.attainable(cell)
        weights, rest = self._wanted(belief, unseen, share)
        length = self._length(cell, unseen, weights, rest)
        if length is not None:
            self._tour = self._tour[:length]
        elif self._finishes or not self._gains(cell, unseen):
            self._tour = []
        tour, finishes = self._search(cell, unseen, weights, rest, length)
        if finishes or not self._tour:
            self._tour, self._finishes = tour, finishes

    def _search(
        self, cell: int, unseen: Bits, weights: NDArray[np.float64], rest: float, length: int | None
    ) -> tuple[list[int], bool]:
        """Return a tour shorter than ``length`` and whether it finishes; up to its last gain if it does not."""
        depth = self._style.depth if length is None else min(length - 1, self._style.depth)
        if depth < 1 or not unseen.any():
            return [], False
        sights = self.sights
        terrain = Terrain(sights.views, sights.passages, sights.soon, self._around, self._keys, weights)
        cells, finishes = shortest_tour(cell, unseen, terrain, rest, self._style._replace(depth=depth))
        tour = cells.tolist()
        return (tour, True) if finishes else (self._upto_last_gain(tour, unseen), False)

    def _wanted(
        self, belief: Belief, unseen: Bits, share: NDArray[np.float64] | None
    ) -> tuple[NDArray[np.float64], float]:
        """Return the weights of cells (C,) and what weight of them may stay unseen.

        What may be spared is spared until only that is left; then the teammates' part is wanted too, and in the end
        every cell, however likely an obstacle.
        """
        open_cells = unpacked(unseen, belief.size)
        chances = np.where(open_cells, self._prior.free_chances(belief), 0.0)
        total = np.count_nonzero(belief == FREE) + chances.sum()
        rest = (1.0 - self._goal) * total + CERTAINTY
        own = chances if share is None else chances * share
        for weights, most in ((own, max(rest, self._spare * total)), (own, rest), (chances, rest)):
            if weights.sum() > most:
                return weights, most
        return open_cells.astype(np.float64), 0.5

    def _length(self, cell: int, unseen: Bits, weights: NDArray[np.float64], rest: float) -> int | None:
        """Return after how many steps the old tour shows enough; None if it never does or is blocked."""
        for steps, following in enumerate(self._tour, 1):
            if following not in self.sights.passages[cell]:
                return None
            cell, unseen = following, unseen & ~self.sights.views[following]
            if weights[unpacked(unseen, weights.size)].sum() <= rest:
                return steps
        return None

    def _gains(self, cell: int, unseen: Bits) -> bool:
        """Tell whether the old tour is open and shows anything."""
        steps = zip([cell, *self._tour], self._tour, strict=False)
        is_open = all(after in self.sights.passages[before] for before, after in steps)
        return is_open and bool(self._upto_last_gain(self._tour, unseen))

    def _upto_last_gain(self, tour: list[int], unseen: Bits) -> list[int]:
        last = 0
        for steps, cell in enumerate(tour, 1):
            if (unseen & self.sights.views[cell]).any():
                last, unseen = steps, unseen & ~self.sights.views[cell]
        return tour[:last]
