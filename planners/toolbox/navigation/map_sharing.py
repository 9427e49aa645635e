"""Flight to teammates that lack parts of the map, in tasks that end once every UAV knows the map.

A UAV with nothing left to explore forecasts where its silent teammates are. The forecast flies a teammate on from its
last received cell: with the map that both had at their last contact, to one frontier cell after the other, through what
this UAV has seen since. The UAV flies to the cell where it meets the first of these tracks. A forecast that comes into
contact range without a contact is wrong, and another one, with other choices of frontier cells, takes its place.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Cell, Distances
from indoor_explorers.env.grid.cells import FREE, UNKNOWN, UNREACHABLE
from indoor_explorers.env.policies.view import Briefing, Mate, View
from indoor_explorers.env.search.frontiers import frontier_mask, on_frontier
from indoor_explorers.env.sensing.lidar import LidarModel, scan
from indoor_explorers.planners.toolbox.navigation.paths import Paths

#: Share of the free cells that a teammate must lack to be flown to.
LACKING = 0.01
#: Lidar ranges of flight beyond the present that a forecast covers.
AHEAD = 12.5
#: Forecasts made for a teammate until contact; then it is taken to have ended.
MOST_FORECASTS = 20
#: Longest silence for which a teammate is flown to, in steps: forecasts start at the last contact.
LONGEST_SILENCE = 2000


class MapSharing:
    """Find the path to the teammate that lacks part of a UAV's map and is met first.

    Call :meth:`observe` once per step.

    Args:
        briefing: Briefing of the UAV.
        paths: The UAV's path search.
        lidar: The lidar by which a forecast's views are computed.

    """

    def __init__(self, briefing: Briefing, paths: Paths, lidar: LidarModel) -> None:
        self._briefing, self._paths, self._lidar = briefing, paths, lidar
        self._lidar_range = float(briefing.lidar_range)
        self._contact = min(briefing.scenario.radio.range, self._lidar_range)
        self._silent: dict[int, SilentMate] = {}

    @staticmethod
    def is_needed(briefing: Briefing) -> bool:
        """Tell whether the task ends once every UAV knows the map, and contact can be lost and found again."""
        scenario = briefing.scenario
        return scenario.goal_of == "every" and briefing.team > 1 and scenario.radio.model not in {"none", "unlimited"}

    def observe(self, view: View) -> None:
        """Store the map at the moment a teammate falls silent; remove it at the next contact."""
        for mate in view.mates:
            if mate.age == 0:
                self._silent.pop(mate.agent, None)
            elif mate.agent not in self._silent:
                self._silent[mate.agent] = SilentMate(view.belief.copy(), mate)

    def path(self, view: View) -> list[Cell]:
        """Return the path to the cell where a teammate is met, the UAV's own cell first; empty if none is to be met."""
        away = self._paths.field(view.belief, view.cell)
        least = LACKING * np.count_nonzero(view.belief == FREE)
        meetings = [
            self._meeting(view, away, self._silent[mate.agent], mate.age)
            for mate in view.mates
            if 0 < mate.age <= LONGEST_SILENCE and self._silent[mate.agent].lacks(view.belief) >= least
        ]
        _, cell = min((meeting for meeting in meetings if meeting is not None), default=(0, None))
        return [] if cell is None else self._paths.to(view.belief, view.cell, cell) or []

    def _meeting(self, view: View, away: Distances, mate: SilentMate, age: int) -> tuple[int, Cell] | None:
        """Return in how many steps and where the teammate is met; None where it is given up.

        ``away`` (H, W) are the steps from this UAV. The UAV meets the teammate once they are in contact range.
        """
        while True:
            ahead = mate.track[age:]
            if len(ahead) and away[tuple(ahead[0])] > self._contact:
                break
            if mate.forecasts == MOST_FORECASTS:
                return None
            mate.track = self._forecast(view, mate, age + round(AHEAD * self._lidar_range))
            mate.forecasts += 1
        steps = away[ahead[:, 0], ahead[:, 1]]
        met = np.flatnonzero(steps - self._contact <= np.arange(len(steps)))
        first = int(met[0]) if len(met) else len(steps) - 1
        row, col = ahead[first].tolist()
        return (max(first, int(steps[first])), (row, col)) if steps[first] < UNREACHABLE else None

    def _forecast(self, view: View, mate: SilentMate, steps: int) -> NDArray[np.int64]:
        """Return the forecast cells of a teammate since the last contact, (``steps`` + 1, 2) rows and columns.

        The first forecast flies to the nearest frontier cells. In later ones every second choice on average is random.
        """
        belief, cell, path = mate.belief.copy(), mate.cell, list[Cell]()
        track = [cell]
        for _ in range(steps):
            seen = scan(view.belief, cell, self._lidar)
            np.copyto(belief, seen, where=seen != UNKNOWN)
            if not path or not on_frontier(belief, path[-1][0] * self._paths.width + path[-1][1], self._paths.rise):
                path = self._next_path(belief, cell, greedy=mate.forecasts == 0)
            if not path:
                break
            cell = path.pop(0)
            track.append(cell)
        return np.array(track + [cell] * (steps + 1 - len(track)))

    def _next_path(self, belief: Belief, cell: Cell, *, greedy: bool) -> list[Cell]:
        """Return a path, without its first cell, to the nearest frontier cell or to a random, probably near one."""
        rng = self._briefing.rng
        if greedy or rng.random() < 0.5:
            return (self._paths.to_frontier(belief, cell, rng) or [])[1:]
        steps = self._paths.field(belief, cell)
        cells = np.argwhere(frontier_mask(belief, self._paths.rise) & (steps < UNREACHABLE))
        if not len(cells):
            return []
        away = steps[cells[:, 0], cells[:, 1]]
        weights = np.exp(-(away - away.min()) / self._lidar_range)
        row, col = rng.choice(cells, p=weights / weights.sum()).tolist()
        return (self._paths.to(belief, cell, (row, col)) or [])[1:]


class SilentMate:
    """What is known of a teammate since the last contact."""

    def __init__(self, belief: Belief, mate: Mate) -> None:
        self.belief = belief
        """The (H, W) map that both had."""
        self.cell = mate.cell
        """Its last received cell."""
        self.track: NDArray[np.int64] = np.empty((0, 2), np.int64)
        """Its forecast cells since then, (T, 2)."""
        self.forecasts = 0
        """Number of forecasts made."""

    def lacks(self, belief: Belief) -> int:
        """Return the number of free cells of a map (H, W) that were unknown at the last contact."""
        return int(np.count_nonzero((belief == FREE) & (self.belief == UNKNOWN)))
