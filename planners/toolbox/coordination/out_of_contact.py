"""Factors on gains that leave cells to teammates out of contact: near silent ones, and in sectors of unheard ones.

Any planner can multiply its gains by these factors. No factor is 0: a teammate out of contact may have ended, and the
cells left to it are explored when no others remain.
"""

from __future__ import annotations

from collections.abc import Callable
from math import pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_explorers.env.grid.arrays import Cell, Distances
from indoor_explorers.env.grid.levels import coordinates
from indoor_explorers.env.policies.view import Briefing, Mate, View
from indoor_explorers.planners.toolbox.navigation.teammates import remembered, whereabouts

#: Smallest factor of one silent teammate.
LEAST = 1e-3
#: Computes the steps (K,) from a cell to each of K candidates on the current map.
StepsFrom = Callable[[Cell], Distances]
#: Computes the steps (H, W) from a cell to all others on the map of a view.
FieldFrom = Callable[[View, Cell], Distances]


class Sectors:
    """The map divided into ``team`` sectors around a point, one for each UAV, for teammates that were never heard.

    Without radio a UAV knows only its own number and the size of the team. This is enough to separate the UAVs: each
    prefers the clusters in its own sector. All sectors have the same number of cells, so that after a start near the
    map's edge no UAV has an empty sector. Over several levels they are upright: each is the same on every level.
    """

    def __init__(self, shape: tuple[int, int], centre: tuple[float, float], team: int) -> None:
        self._centre = centre
        self._team = team
        rows, cols = np.mgrid[: shape[0], : shape[1]]
        self._bearings = np.sort(self._bearing(rows, cols).ravel())

    @classmethod
    def of(cls, briefing: Briefing, start: Cell) -> Sectors:
        """Return the sectors of a briefing's map, or of a level of it, for a UAV that started in ``start``.

        They meet there, or in the middle of the map if the UAVs started in different places.
        """
        _, height, width = briefing.levels
        if briefing.scenario.spawn == "clustered":
            return cls((height, width), briefing.levels.voxel(start)[1:], briefing.team)
        return cls((height, width), ((height - 1) / 2, (width - 1) / 2), briefing.team)

    def shares(self, points: NDArray[np.float64], agent: int, strength: float) -> NDArray[np.float64]:
        """Return the factors of clusters at (K, 2) rows and columns of a level for a UAV, (K,) in (0, 1].

        The factor is 1 in the middle of its sector and e^(-2 ``strength``) on the opposite side. Angles are measured by
        the share of the map's cells that they cover.
        """
        swept = np.searchsorted(self._bearings, self._bearing(*points.T)) / len(self._bearings)
        own = (agent + 0.5) / self._team
        return np.asarray(np.exp(strength * (np.cos(2.0 * pi * (swept - own)) - 1.0)))

    def _bearing(self, rows: ArrayLike, cols: ArrayLike) -> NDArray[np.float64]:
        return np.asarray(
            np.arctan2(np.subtract(rows, self._centre[0]), np.subtract(cols, self._centre[1])), np.float64
        )


class OutOfContact:
    """Compute the factors of one UAV for the teammates that it is out of contact with, during one episode.

    A silent teammate is assumed to work around its last received cell or goal, and one that was never heard in its
    sector of the map. Forgotten teammates have no influence.

    Args:
        briefing: Briefing of the UAV.
        silence: Lidar ranges by which a silent teammate must be closer to a candidate for a factor of e^-1.
        sector: Preference for the own sector while teammates were never heard; the factor on the opposite side is
            e^(-2 sector).

    """

    def __init__(self, briefing: Briefing, *, silence: float = 0.3, sector: float = 3.0) -> None:
        self._briefing = briefing
        self._silence = silence * briefing.lidar_range
        self._sector = sector
        self._sectors: Sectors | None = None

    def factors(
        self, view: View, points: NDArray[np.float64], own_steps: Distances, steps_from: StepsFrom
    ) -> NDArray[np.float64]:
        """Return the factors of K candidates, (K,) in (0, 1], for all teammates out of contact.

        ``points`` (K, 2) are the candidates' rows and columns on their levels, ``own_steps`` (K,) their path lengths
        from this UAV. The first call must be made in the UAV's start cell.
        """
        left = self.left_by_unheard(view, points)
        for mate in remembered(view, self._briefing):
            if mate.age > 0:
                left *= self._left_by_silent(mate, own_steps, steps_from)
        return left

    def at_cells(
        self, view: View, cells: NDArray[np.int32], own_steps: Distances, field_from: FieldFrom
    ) -> NDArray[np.float64]:
        """Return the factors of (K,) flat cells, (K,) in (0, 1], as :meth:`factors` does."""
        return self.factors(view, self._points(cells), own_steps, lambda cell: field_from(view, cell).ravel()[cells])

    def left_by_unheard(self, view: View, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the factors of K candidates, (K,) in (0, 1], for teammates never heard, from the sectors alone."""
        if self._sectors is None:
            self._sectors = Sectors.of(self._briefing, view.cell)
        unheard = self._briefing.team - 1 - len(view.mates)
        if unheard == 0:
            return np.ones(len(points))
        return self._sectors.shares(points, self._briefing.agent, self._sector * unheard / (self._briefing.team - 1))

    def left_by_unheard_at_cells(self, view: View, cells: NDArray[np.int32]) -> NDArray[np.float64]:
        """Return the factors of (K,) flat cells, (K,) in (0, 1], as :meth:`left_by_unheard` does."""
        return self.left_by_unheard(view, self._points(cells))

    def _left_by_silent(self, mate: Mate, own_steps: Distances, steps_from: StepsFrom) -> NDArray[np.float64]:
        ahead = np.maximum(0, own_steps - steps_from(whereabouts(mate)))
        return np.asarray(np.maximum(LEAST, np.exp(-ahead / self._silence)))

    def _points(self, cells: NDArray[np.int32]) -> NDArray[np.float64]:
        """Return the rows and columns (K, 2) of (K,) flat cells, on their levels."""
        return coordinates(cells, self._briefing.shape[1], self._briefing.rise)[:, -2:].astype(np.float64)
