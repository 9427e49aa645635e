"""Sectors of the map, one for each UAV, for teammates that have never been heard.

Without radio a UAV knows only its own number and the size of the team. This is enough to separate the UAVs: each
prefers the clusters in its own sector of the map. The sectors meet in the team's start, or in the middle of the map if
the UAVs started in different places. All sectors have the same number of cells, so that after a start near the map's
edge no UAV has an empty sector.
"""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.policies.view import Briefing


class Sectors:
    """The map divided into ``team`` sectors of equal area around a point."""

    def __init__(self, shape: tuple[int, int], centre: tuple[float, float], team: int) -> None:
        self._centre = centre
        self._team = team
        rows, cols = np.mgrid[: shape[0], : shape[1]]
        self._bearings = np.sort(self._bearing(rows, cols).ravel())

    @classmethod
    def of(cls, briefing: Briefing, start: Cell) -> Sectors:
        """Return the sectors of a briefing's map for a UAV that started in ``start``."""
        together = briefing.scenario.spawn == "clustered"
        middle = (briefing.shape[0] - 1) / 2, (briefing.shape[1] - 1) / 2
        return cls(briefing.shape, start if together else middle, briefing.team)

    def shares(self, points: NDArray[np.float64], agent: int, strength: float) -> NDArray[np.float64]:
        """Return the factors of clusters at (K, 2) rows and columns for a UAV, (K,) in (0, 1].

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
