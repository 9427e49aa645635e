"""One level after the other: a planner for plain maps on maps of several levels."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

from indoor_explorers.env.grid.cells import Action
from indoor_explorers.env.policies.explanation import Explanation
from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, Mate, View
from indoor_explorers.planners.frontier.nearest import NearestPilot
from indoor_explorers.planners.toolbox.explorers import ExploringWith
from indoor_explorers.planners.toolbox.navigation.paths import Paths


@dataclass(frozen=True, kw_only=True)
class LevelByLevel(ExploringWith):
    """Let another policy explore each level as a plain map, one after the other.

    A UAV explores the level that it is on until no frontier cell of it is in reach, and flies to the nearest frontier
    cell of the building. It is the control for planners that plan over levels. On plain maps it is the other policy.
    """

    plans_for: ClassVar[str] = ALL_CELLS

    stay: bool = False
    """Whether UAVs stay on the level that they start on, at one height."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        explorer = self.make_explorer()
        return explorer.pilot(briefing) if briefing.level_count == 1 else LevelPilot(briefing, explorer, self.stay)


class LevelPilot(NearestPilot):
    """Let a pilot of the other policy explore a level, and fly to the next one when that is done.

    Args:
        briefing: Briefing of the UAV.
        explorer: The policy that explores a level.
        stay: Whether to stay on the first level.

    """

    def __init__(self, briefing: Briefing, explorer: Policy, stay: bool) -> None:
        super().__init__(briefing)
        self._explorer, self._stay, self._levels = explorer, stay, briefing.levels
        size = self._levels.height, self._levels.width
        self._on_level = replace(briefing, shape=size, level_count=1)
        self._level_paths = Paths(size)
        self._level, self._explores = -1, False
        self._pilot: Pilot  # of the level that the UAV is on, from its first step on

    def act(self, view: View) -> int:
        """Explore the level, or fly to the next one."""
        level, row, col = self._levels.voxel(view.cell)
        if level != self._level:
            self._level, self._pilot = level, self._explorer.pilot(self._on_level)
        flat = self.seen_on(view, level)
        self.navigator.observe(view)
        self._explores = bool(self._level_paths.to_frontier(flat.belief, (row, col), self.rng))
        if self._explores:
            self.navigator.set_goal(view, None)
            self._pilot.explaining = self.explaining
            action = self._explorer.act([self._pilot], [flat])[0]
            self.message, self.done = self._pilot.message, False
            return action
        self.message = None
        if self._stay:
            self.done = True
            return Action.STAY
        return self.proceed(view)

    def seen_on(self, view: View, level: int) -> View:
        """Return a view of one level as a plain map, with the teammates that were last heard of on it."""
        first = level * (self._levels.height + 1)
        rows = slice(first, first + self._levels.height)
        mates = [mate for mate in view.mates if self._levels.voxel(mate.cell)[0] == level]
        return view._replace(
            belief=view.belief[rows],
            visited=view.visited[rows],
            cell=(view.cell[0] - first, view.cell[1]),
            legal=view.legal[: Action.STAY + 1],
            mates=tuple(_on_level(mate, first) for mate in mates),
        )

    def explain(self) -> Explanation:
        """Return why the UAV flies to another level; on a level, only that it explores there."""
        note = f"explores level {self._level}" if self._explores else "flies to the nearest frontier of the building"
        return replace(super().explain(), note=note)


def _on_level(mate: Mate, first: int) -> Mate:
    """Return a teammate with its cell on a level whose first row is ``first``."""
    return mate._replace(cell=(mate.cell[0] - first, mate.cell[1]))
