"""SGBA: each UAV flies along its own bearing and follows the walls in its way (McGuire et al. 2019)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import atan2, cos, hypot, inf, isfinite, pi, sin
from typing import ClassVar

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import Action
from indoor_explorers.env.policies.explanation import Explanation
from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot
from indoor_explorers.planners.toolbox.navigation.teammates import linked
from indoor_explorers.planners.toolbox.parameters import Parameters, bounded

#: Headings 0 to 3.
CLOCKWISE = (Action.UP, Action.RIGHT, Action.DOWN, Action.LEFT)
#: Fewest steps without new cells before a UAV finishes, for lidars of any range.
SHORTEST_PATIENCE = 8


@dataclass(frozen=True, kw_only=True)
class Sgba(Parameters, Policy):
    """Keep a preferred bearing, 2 pi i / N for UAV i of N, and follow the walls in its way.

    This is the outbound part of the swarm gradient bug algorithm; there is neither a battery nor a beacon to return to.
    A UAV leaves a wall where its bearing is free and it is farther along the bearing than where it met the wall, so
    that it does not return into a dead end. It takes another bearing when it returns to where it met the wall, and
    turns away from a linked teammate of lower number that is ``near``.

    It plans nothing and does not store which cells it missed: in a room it follows the walls, in open space it flies
    straight ahead, and alone it rarely sees everything. With ``finish`` it therefore flies to nearest frontiers for the
    rest of the episode once no cell has become known for some time, or none is left; the tally counts these steps
    (``finishing_steps``). Cells from linked teammates count as well, so large groups switch late. A UAV that a teammate
    blocks also flies to its nearest frontier, and continues in another direction (``held_up_steps``): two UAVs that
    follow the same wall and meet in a corridor would block each other for ever.

    K. N. McGuire, C. De Wagter, K. Tuyls, H. J. Kappen, G. C. H. E. de Croon, "Minimal navigation solution for a
    swarm of tiny flying robots to explore an unknown environment", Science Robotics 4(35), 2019,
    doi:10.1126/scirobotics.aaw9710.
    """

    plans_for: ClassVar[str] = ALL_CELLS

    near: float = bounded(1.0, least=0, tunable=(0.0, 4.0))
    """Distance to a linked teammate of lower number at which a UAV changes its bearing, in lidar ranges."""
    finish: bool = True
    """Whether to fly to nearest frontiers in the end; if False, an episode may last to its budget."""
    patience: float = bounded(4.0, least=0, tunable=(1.0, 16.0, "log"))
    """Steps without new cells before that, per cell of the lidar range."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return SgbaPilot(briefing, self)


class SgbaPilot(GoalPilot):
    """Fly along the bearing or along a wall; in the end, to nearest frontiers."""

    def __init__(self, briefing: Briefing, policy: Sgba) -> None:
        super().__init__(briefing)
        reach = briefing.lidar_range
        self._near = policy.near * reach
        self._patience = max(SHORTEST_PATIENCE, policy.patience * reach) if policy.finish else inf
        self._set_bearing(2 * pi * briefing.agent / briefing.team)
        self._side = 1 if briefing.agent % 2 else -1
        self._heading = 0
        self._met: Cell | None = None
        self._along = 0
        self._grew_at = 0
        self._turned_at = -self._near
        self._finishing = self._held_up = 0
        self._finishes = self._detours = False

    def act(self, view: View) -> int:
        """Run one step of the state machine: along the bearing, along a wall, or to a frontier."""
        self.navigator.observe(view)
        if not self._finishes and self._is_finished(view):
            self.choose_goal(view)
            self._finishes = True
        if self._finishes:
            self._finishing += 1
            return self.proceed(view)
        if self._is_held_up(view):
            self._held_up += 1
            return self.proceed(view)
        self._turn_from_mates(view)
        return self._fly_out(view) if self._met is None else self._follow(view, self._met)

    def choose(self, view: View) -> Cell | None:
        """Return the nearest frontier cell."""
        return self.nearest_frontier(view)

    def explain(self) -> Explanation:
        """Return in which state the UAV is; it has a goal only where it flies to a frontier."""
        told = super().explain()
        if self._finishes or self._detours:
            why = "to finish" if self._finishes else "as a teammate is in the way"
            return replace(told, note=f"the nearest frontier, {why}")
        return replace(told, goal=None, path=(), note="along its bearing" if self._met is None else "along a wall")

    def tally(self) -> dict[str, float]:
        """Return also the steps of flying to nearest frontiers, to finish or because a teammate was in the way."""
        return {
            **super().tally(),
            "finishing_steps": float(self._finishing),
            "held_up_steps": float(self._held_up),
        }

    def _is_held_up(self, view: View) -> bool:
        """Tell whether a teammate is in the way, from the first failed move until the substitute goal is explored."""
        if self._detours and (self.goal is None or self.is_spent(view, self.goal)):
            self._detours = False
            self._set_bearing(atan2(self._east, self._north) + pi / 2 * int(self.rng.integers(1, 4)))
        elif not self._detours and (self.navigator.oscillates or self.navigator.is_stationary):
            self._detours = True
            self.choose_goal(view)
        return self._detours

    def _is_finished(self, view: View) -> bool:
        """Tell whether no cell has become known for too long, or no frontier is left."""
        if not self.map_grew:
            return view.step - self._grew_at > self._patience
        self._grew_at = view.step
        return isfinite(self._patience) and self.paths.to_frontier(view.belief, view.cell, self.rng) is None

    def _set_bearing(self, bearing: float) -> None:
        """Set the bearing, clockwise from up, and stop following a wall."""
        self._north, self._east = cos(bearing), sin(bearing)
        self._debt = 0.0
        self._met = None

    def _progress(self, cell: Cell) -> float:
        return self._east * cell[1] - self._north * cell[0]

    def _headings(self) -> tuple[int, int]:
        """Return the vertical and the horizontal heading nearest to the bearing."""
        return (0 if self._north >= 0 else 2), (1 if self._east >= 0 else 3)

    def _fly_out(self, view: View) -> int:
        """Step along the bearing like a line on a grid, or start to follow a wall."""
        share = abs(self._east) / (abs(self._east) + abs(self._north))
        across = self._debt + share >= 0.5 and share > 1e-9
        self._debt += share - across
        heading = self._headings()[across]
        if not view.legal[CLOCKWISE[heading]]:
            self._met, self._along = view.cell, 0
            self._heading = (heading - self._side) % 4
            return self._follow(view, view.cell)
        self._heading = heading
        return int(CLOCKWISE[heading])

    def _follow(self, view: View, met: Cell) -> int:
        """Follow the wall until the bearing is free, farther along it than where the wall was met."""
        if self._along and view.cell == met:
            self._set_bearing(atan2(self._east, self._north) + pi / 2 * int(self.rng.integers(1, 4)))
            return self._fly_out(view)
        ahead = self._headings()[abs(self._east) > abs(self._north)]
        if self._along and view.legal[CLOCKWISE[ahead]] and self._progress(view.cell) > self._progress(met) + 0.5:
            self._met = None
            return self._fly_out(view)
        self._along += 1
        for turn in (self._side, 0, -self._side, 2):
            heading = (self._heading + turn) % 4
            if view.legal[CLOCKWISE[heading]]:
                self._heading = heading
                return int(CLOCKWISE[heading])
        return int(Action.STAY)

    def _turn_from_mates(self, view: View) -> None:
        """Turn the bearing away from a near linked teammate of lower number, not too often."""
        if view.step - self._turned_at < self._near:
            return
        for mate in linked(view):
            rows, cols = view.cell[0] - mate.cell[0], view.cell[1] - mate.cell[1]
            if mate.agent < self.briefing.agent and 0 < hypot(rows, cols) <= self._near:
                self._set_bearing(atan2(cols, -rows))
                self._turned_at = view.step
                return
