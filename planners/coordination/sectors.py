"""Sectors of the map, one for each UAV, for teammates that have never been heard.

Without radio a UAV knows only its own number and the size of the team. That is enough to separate: each UAV prefers the
clusters in its own sector of the map. The sectors meet where the team started, or in the middle of the map when
the UAVs started in different places. All sectors hold the same number of cells, so that no UAV is sent off the map
near its edge.
"""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.policies.view import Briefing


class Sectors:
    """The map cut into ``team`` sectors of equal area around a point."""

    def __init__(self, shape: tuple[int, int], centre: tuple[float, float], team: int) -> None:
        self._centre = centre
        self._team = team
        rows, cols = np.mgrid[: shape[0], : shape[1]]
        self._bearings = np.sort(self._bearing(rows, cols).ravel())

    @classmethod
    def of(cls, briefing: Briefing, start: Cell) -> Sectors:
        """Cut the map of a briefing for a UAV that started in ``start``."""
        together = briefing.scenario.spawn == "clustered"
        middle = (briefing.shape[0] - 1) / 2, (briefing.shape[1] - 1) / 2
        return cls(briefing.shape, start if together else middle, briefing.team)

    def shares(self, points: NDArray[np.float64], agent: int, strength: float) -> NDArray[np.float64]:
        """Return how much of clusters at (K, 2) rows and columns is a UAV's own, (K,) in (0, 1].

        1 in the middle of its sector, e^(-2 ``strength``) opposite. An angle counts as the share of the map's cells
        that it sweeps.
        """
        swept = np.searchsorted(self._bearings, self._bearing(*points.T)) / len(self._bearings)
        own = (agent + 0.5) / self._team
        return np.asarray(np.exp(strength * (np.cos(2.0 * pi * (swept - own)) - 1.0)))

    def _bearing(self, rows: ArrayLike, cols: ArrayLike) -> NDArray[np.float64]:
        return np.asarray(
            np.arctan2(np.subtract(rows, self._centre[0]), np.subtract(cols, self._centre[1])), np.float64
        )
