"""SGBA: fly in a direction of one's own and follow the walls in the way (McGuire et al. 2019)."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, hypot, inf, isfinite, pi, sin

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import Action
from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.coordination.teammates import linked
from indoor_explorers.planners.navigation.goal_pilot import GoalPilot
from indoor_explorers.planners.parameters import at_least

#: Headings 0 to 3.
CLOCKWISE = (Action.UP, Action.RIGHT, Action.DOWN, Action.LEFT)
#: Steps without anything new that are always waited for, however short the lidar's range.
SHORTEST_PATIENCE = 8


@dataclass(frozen=True, kw_only=True)
class Sgba(Policy):
    """Keep a preferred bearing, 2 pi i / N for UAV i of N, and follow the walls in its way.

    The outward half of the swarm gradient bug algorithm; there is neither a battery here nor a beacon to come back to.
    A UAV leaves a wall where its bearing is free and it is farther along it than where it met the wall, which is what
    keeps it from flying back into a dead end. It turns to another bearing when it comes round to where it met the
    wall, and away from a linked teammate of lower number that is ``near``.

    It plans nothing and keeps no list of what it missed: in a room it goes round the walls, in open space it flies
    straight through, and alone it rarely sees everything. ``finish`` therefore hands over to nearest frontiers for
    the rest of the episode once the UAV has learned nothing new for a while or nothing is left to learn; the tally
    counts these steps (``finishing_steps``). What linked teammates learn is news, too: large groups hand over late.
    A UAV whose way is blocked flies to its nearest frontier, too, and then on in another direction
    (``held_up_steps``): followers of the same wall who meet in a corridor would stand there for good.

    K. N. McGuire, C. De Wagter, K. Tuyls, H. J. Kappen, G. C. H. E. de Croon, "Minimal navigation solution for a
    swarm of tiny flying robots to explore an unknown environment", Science Robotics 4(35), 2019,
    doi:10.1126/scirobotics.aaw9710.
    """

    near: float = 1.0
    """Distance to a linked teammate of lower number at which the bearing is changed, in lidar ranges."""
    finish: bool = True
    """Whether to end with nearest frontiers. Without it an episode may last to its budget."""
    patience: float = 4.0
    """How long nothing new may be learned before that, in steps per cell of lidar range."""

    def __post_init__(self) -> None:
        """Refuse negative distances and times."""
        at_least(self, 0.0, "near", "patience")

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the mind of one UAV."""
        return SgbaPilot(briefing, self)


class SgbaPilot(GoalPilot):
    """Fly outwards or along a wall; in the end, to nearest frontiers."""

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
        self._news_at = 0
        self._turned_at = -self._near
        self._finishing = self._held_up = 0
        self._finishes = self._detours = False

    def act(self, view: View) -> int:
        """Take one step of the state machine: outwards, along a wall, or to a frontier."""
        self.navigator.observe(view)
        if not self._finishes and self._has_had_enough(view):
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

    def tally(self) -> dict[str, float]:
        """Return also for how many steps the UAV flew to nearest frontiers, to finish or because it was held up."""
        return {
            **super().tally(),
            "finishing_steps": float(self._finishing),
            "held_up_steps": float(self._held_up),
        }

    def _is_held_up(self, view: View) -> bool:
        """Tell whether a UAV is in the way, from the first sign until the frontier flown to instead is explored."""
        if self._detours and (self.goal is None or self.is_spent(view, self.goal)):
            self._detours = False
            self._set_bearing(atan2(self._east, self._north) + pi / 2 * int(self.rng.integers(1, 4)))
        elif not self._detours and (self.navigator.swings or self.navigator.stands):
            self._detours = True
            self.choose_goal(view)
        return self._detours

    def _has_had_enough(self, view: View) -> bool:
        """Tell whether nothing new was learned for too long, or nothing is left to learn."""
        if not self.map_grew:
            return view.step - self._news_at > self._patience
        self._news_at = view.step
        return isfinite(self._patience) and self.paths.to_frontier(view.belief, view.cell, self.rng) is None

    def _set_bearing(self, bearing: float) -> None:
        """Take a bearing, clockwise from up, and forget the wall."""
        self._north, self._east = cos(bearing), sin(bearing)
        self._debt = 0.0
        self._met = None

    def _progress(self, cell: Cell) -> float:
        return self._east * cell[1] - self._north * cell[0]

    def _headings(self) -> tuple[int, int]:
        """Return the vertical and the horizontal heading nearest to the bearing."""
        return (0 if self._north >= 0 else 2), (1 if self._east >= 0 else 3)

    def _fly_out(self, view: View) -> int:
        """Step along the bearing as a line is drawn on a grid, or meet a wall."""
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
        """Keep the wall at one side until the bearing is free beyond where it was met."""
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
        """Head straight away from a linked teammate of lower number that is near, at most once a while."""
        if view.step - self._turned_at < self._near:
            return
        for mate in linked(view):
            rows, cols = view.cell[0] - mate.cell[0], view.cell[1] - mate.cell[1]
            if mate.agent < self.briefing.agent and 0 < hypot(rows, cols) <= self._near:
                self._set_bearing(atan2(cols, -rows))
                self._turned_at = view.step
                return
