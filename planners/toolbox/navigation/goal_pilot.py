"""A pilot that flies to goals; planners only choose them.

Each step goes through the same states, whatever the planner::

    observe -> [map grew] -> on_map_growth
       |
       +- no goal:           map grew?                         -> choose
       +- is_spent(goal):    nothing left to see there         -> choose
       +- overdue:           not reached in time; ban the goal -> choose
       +- wants_replan:      and the UAV does not oscillate    -> choose; by default, if the map has grown and the last
       |                                                          choice is ``replan_period`` steps old
       +- else:              keep the goal; new path if the map grew or the UAV left its path
       |
    next_action: blocked twice by a teammate? detour, other frontier, or retreat; else the next cell of the path

Without a goal a UAV stays where it is; in tasks that end once every UAV knows the map, it flies to teammates that lack
parts of it (:class:`~.map_sharing.MapSharing`).

If ``choose`` finds nothing, it is called once more without bans; and where maps can be wrong, with doubtful obstacles
taken as unknown, as wrong ones may close a door. :class:`~.navigator.Navigator` follows the paths.
"""

from __future__ import annotations

from abc import abstractmethod
from math import inf
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_explorers.env.grid.arrays import Cell, Distances, Mask
from indoor_explorers.env.grid.cells import OCCUPIED, UNKNOWN, UNREACHABLE
from indoor_explorers.env.grid.levels import coordinates
from indoor_explorers.env.policies.explanation import Candidate, Explanation, ranked
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.search.frontiers import on_frontier
from indoor_explorers.env.sensing.inverse_model import HIT
from indoor_explorers.env.sensing.lidar import LidarModel, lidar_model
from indoor_explorers.planners.toolbox.frontiers.clusters import Clusters, frontier_clusters
from indoor_explorers.planners.toolbox.navigation.map_sharing import MapSharing
from indoor_explorers.planners.toolbox.navigation.navigator import Navigator
from indoor_explorers.planners.toolbox.navigation.teammates import remembered, whereabouts

#: Log-odds up to which obstacles are doubted when no other goal is left, in turn.
DOUBTED = (4 * HIT, 16 * HIT, 64 * HIT)


class GoalPilot(Pilot):
    """Fly to goals that a subclass chooses.

    A goal is kept until it is no longer a frontier cell. A UAV always sees its four neighbours, so a reached goal is
    not a frontier cell any more; and as long as a frontier cell is reachable there is a goal. So every reachable cell
    becomes known. A UAV that oscillates between two cells, as when two UAVs keep reacting to each other's goals, keeps
    its goal.
    """

    changes_levels: ClassVar[bool] = False
    """Whether the planner plans over all levels of a map of several; those that do not, stay on theirs."""
    straight: ClassVar[bool] = False
    """Whether to fly the straightest shortest path (:mod:`~.straight_paths`)."""

    replan_period: float = inf
    """Steps after a choice from which on growth of the map leads to another choice, although the goal is still useful.
    With 0, growth does so at once; if infinite, never."""

    def __init__(self, briefing: Briefing) -> None:
        self.briefing = briefing
        self.rng = briefing.rng
        self.navigator = Navigator(briefing, straight=self.straight, rise=briefing.rise if self.changes_levels else 0)
        self.paths = self.navigator.paths
        self.lidar = self.lidar_of(float(briefing.lidar_range))
        """The lidar by which views are planned: over all levels, or over the UAV's own."""
        self.plans = 0
        """Number of goals chosen so far."""
        self._grew_since_choice = False
        self._next_choice = inf
        self._sharing = MapSharing(briefing, self.paths, self.lidar) if MapSharing.is_needed(briefing) else None
        self._chosen_at, self._supposed = 0, dict[int, Cell]()
        self._candidates_kept: tuple[Candidate, ...] = ()
        self._score_kept = ""

    def lidar_of(self, reach: float) -> LidarModel:
        """Return the UAV's lidar with another range, in cells."""
        levels = self.briefing.level_count if self.changes_levels else 1
        return lidar_model(reach, "exact", levels, self.briefing.scenario.lidar.elevation)

    def clusters(self, view: View) -> Clusters:
        """Return the frontier clusters of a view, on all levels or on the UAV's own ones."""
        return frontier_clusters(view.belief, self.briefing.lidar_range, self.paths.rise)

    def coordinates(self, cells: NDArray[np.int32] | Cell) -> NDArray[np.int64]:
        """Return the rows and columns (..., 2) of flat cells (...) or of a cell, (2,).

        Where the pilot changes levels, return the levels, rows and columns, (..., 3) or (3,).
        """
        flat = np.array(cells[0] * self.paths.width + cells[1]) if isinstance(cells, tuple) else cells
        return coordinates(flat, self.paths.width, self.paths.rise)

    @abstractmethod
    def choose(self, view: View) -> Cell | None:
        """Return the frontier cell to fly to next, except :meth:`near_banned` ones; None if none is reachable."""

    def on_map_growth(self, view: View) -> None:  # a hook that most planners leave empty
        """Handle new knowledge of the map; called before any choice of a goal."""

    def is_spent(self, view: View, goal: Cell) -> bool:
        """Tell whether a goal is no longer useful: by default, if it is no frontier cell."""
        return not on_frontier(view.belief, goal[0] * self.paths.width + goal[1], self.paths.rise)

    def wants_replan(self, view: View) -> bool:
        """Tell whether to choose again although the goal is still useful; called at every step.

        By default, if the map has grown since the last choice, and that was at least :attr:`replan_period` steps ago.
        """
        return self._grew_since_choice and view.step >= self._next_choice

    @property
    def goal(self) -> Cell | None:
        """The current goal."""
        return self.navigator.goal

    @property
    def map_grew(self) -> bool:
        """Whether cells have become known since the last step."""
        return self.navigator.map_grew

    def act(self, view: View) -> int:
        """Follow the path to the goal, and choose another goal if due."""
        self.navigator.observe(view)
        return self.proceed(view)

    def proceed(self, view: View) -> int:
        """Return the next move towards the goal, after :meth:`Navigator.observe`."""
        navigator = self.navigator
        if navigator.map_grew:
            self._grew_since_choice = True
            self.on_map_growth(view)
        if self._choice_is_due(view):
            self.choose_goal(view)
        elif navigator.map_grew or navigator.is_off_path(view):
            navigator.find_path(view)
        if self._sharing is not None:
            self._share_map(view, self._sharing)
        return navigator.next_action(view)

    def _share_map(self, view: View, sharing: MapSharing) -> None:
        """Fly to a teammate that lacks parts of the map if there is no goal."""
        sharing.observe(view)
        if self.goal is None:
            self.navigator.follow(sharing.path(view))

    def choose_goal(self, view: View) -> None:
        """Choose a goal and a path to it; a banned goal if there is no other."""
        self.plans += 1
        if self.explaining:
            self._chosen_at, self._candidates_kept, self._score_kept = view.step, (), ""
            self._supposed = {mate.agent: whereabouts(mate) for mate in remembered(view, self.briefing)}
        self._grew_since_choice, self._next_choice = False, view.step + self.replan_period
        goal = self.choose(view)
        if goal is None and self.navigator.lift_bans():
            goal = self.choose(view)
        if goal is None and view.log_odds is not None:
            goal = self._beside_doubtful(view, view.log_odds)
        self.navigator.set_goal(view, goal)
        self.done = goal is None

    def _beside_doubtful(self, view: View, log_odds: NDArray[np.float32]) -> Cell | None:
        """Return a goal beside an obstacle of low log-odds; None if there is none."""
        for most in DOUBTED:
            belief = np.where((view.belief == OCCUPIED) & (log_odds <= most), UNKNOWN, view.belief)
            goal = self.choose(view._replace(belief=belief))
            if goal is not None:
                return goal
        return None

    def consider(self, cells: NDArray[np.integer[Any]], score: str, scores: ArrayLike, **parts: ArrayLike) -> None:
        """Keep what the present choice is made among, if anybody asks (:attr:`explaining`).

        ``cells`` (K,) are flat; ``score`` says in a few words what the ``scores`` (K,) are, the larger the better;
        ``parts`` (K,) are what they are made of. Candidates to which there are no known ``steps`` are left out.
        """
        if self.explaining:
            reached = np.less(parts.get("steps", 0), UNREACHABLE)
            scores = np.where(reached, scores, -np.inf)
            self._candidates_kept, self._score_kept = ranked(cells, self.paths.width, scores, parts), score

    def explain(self) -> Explanation:
        """Return the goal, the path to it, and what was considered in the latest choice."""
        return Explanation(
            step=self._chosen_at,
            goal=self.goal,
            candidates=self._candidates_kept,
            score=self._score_kept,
            path=tuple(self.navigator.path),
            mates=self._supposed,
            note=self.note_on_choice(),
        )

    def note_on_choice(self) -> str:  # a hook that most planners leave empty
        """Return what else there is to say about the latest choice."""
        return ""

    def tally(self) -> dict[str, float]:
        """Return the number of goals given up because teammates were in the way, and of goals chosen."""
        return {"goals_given_up": float(self.navigator.given_up), "plans": float(self.plans)}

    def steps_from(self, view: View, cell: Cell) -> Distances:
        """Return the (H, W) steps from a cell through known free cells; those from the UAV's cell are cached."""
        return self.navigator.steps_from(view, cell)

    def near_banned(self, view: View, cells: NDArray[np.int32]) -> Mask:
        """Return which of (K,) flat cells are too close to a banned goal, (K,) bool."""
        return self.navigator.near_banned(view, cells)

    def near_goal(self, goal: Cell | None, cells: NDArray[np.int32], radius: float, norm: np.ufunc = np.hypot) -> Mask:
        """Return which of (K,) flat cells are at most ``radius`` cells from a goal, (K,) bool; none if there is none.

        Distances are straight lines; with ``np.maximum`` as ``norm``, the largest one of those along the axes.
        """
        if goal is None:
            return np.zeros(len(cells), np.bool_)
        return np.asarray(norm.reduce(np.abs(self.coordinates(cells) - self.coordinates(goal)), axis=-1) <= radius)

    def goal_factors(
        self, goal: Cell | None, cells: NDArray[np.int32], radius: float, bonus: float
    ) -> NDArray[np.float64]:
        """Return the factors on the values of (K,) flat cells: ``1 + bonus`` :meth:`near_goal`, else 1, (K,)."""
        return np.where(self.near_goal(goal, cells, radius), 1.0 + bonus, 1.0)

    def steps_in(self, lidar_ranges: float) -> int:
        """Return a length in lidar ranges as a number of steps, at least 1."""
        return max(1, round(lidar_ranges * self.briefing.lidar_range))

    def nearest_frontier(self, view: View) -> Cell | None:
        """Return the frontier cell with the shortest known path, drawn at random among equals; None if unreachable."""
        return self.navigator.nearest_frontier(view)

    def _choice_is_due(self, view: View) -> bool:
        if self.goal is None:
            return self.map_grew or view.log_odds is not None
        if self.is_spent(view, self.goal) or self.navigator.is_overdue(view):
            return True
        return self.navigator.may_replan and self.wants_replan(view)
