"""Pilots of a team on the graphs of another simulator: each is shown a grid, and taken along the graph to its goal.

The simulator moves the robots in turn, each to a neighbouring node of its own graph, where it scans. Pilots plan in
cells: one is shown its robot's map, its teammates and its cell, and chooses where to fly to. The robot then moves to
the next node on the way with the least sum of pixels and a price for every move, as the simulator counts both.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from indoor_explorers.env.grid.arrays import Belief, Cell, Distances, Mask, read_only
from indoor_explorers.env.grid.cells import FREE, MOVES, OCCUPIED, UNKNOWN, UNREACHABLE
from indoor_explorers.env.interfaces.ros import legal_moves
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.view import Mate, Message, View, message_numbers
from indoor_explorers.planners.toolbox.coordination.sequence_chooser import SequenceChooser
from indoor_explorers.planners.toolbox.information.candidates import local_candidates
from indoor_explorers.planners.toolbox.navigation.candidate_pilot import CandidatePilot
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot
from indoor_explorers.planners.toolbox.navigation.paths import Paths
from indoor_explorers.planners.toolbox.navigation.teammates import GroupMember
from indoor_explorers.planners.toolbox.routing.sequences import DecisionProblem

#: Pixels of the simulator along the side of a cell of the view.
SCALE = 4
#: Nodes along the sides of the map, and nearest nodes that a robot can move to.
LATTICE, NEIGHBOURS = 50, 30
#: Most candidates within a move that each robot adds to those of its pilot.
LOOKOUTS = 8
#: Steps of a view that a move counts as, for each cell that it is long at most: paths in views are not straight.
STEPS_A_CELL = 1.2
#: Pixels by which a first move may cost more than the cheapest one.
SLACK = 8.0
#: Most moves that a pilot without a goal is followed.
FOLLOWED = 20
#: Most goals that a pilot is asked for until one is left to see from another node.
MOST_GOALS = 8
#: Cells around a goal that show nothing more from the graph, and for how many moves they count as obstacles.
SHUT, SHUT_MOVES = 3, 20


@dataclass(frozen=True, kw_only=True, eq=False)
class Turn:
    """What the robot knows whose turn it is, with N nodes; places are pixels (row, column)."""

    robot: int
    """Its number."""
    step: int
    """Moves of each robot before this step."""
    done: bool
    """Whether the simulator ends here."""
    linked: Sequence[int]
    """The robots in contact after the last move, with the one that moved."""
    places: NDArray[np.int32]
    """(team, 2) where the robots are; a pilot is told of those heard alone."""
    flown: NDArray[np.float64]
    """(team,) pixels."""
    explored: NDArray[np.float64]
    """(team,) shares of the free pixels that each robot knows."""
    belief: Belief
    """(H, W) uint8, 0 unknown, 1 free, 2 occupied."""
    nodes: NDArray[np.int32]
    """(N, 2) nodes."""
    edges: NDArray[np.int32]
    """(E, 2) numbers of nodes, from the first of which a robot moves to the second in a straight line."""
    node: int
    """Where the robot is."""

    @classmethod
    def of(cls, answer: Mapping[str, Any]) -> Turn:
        """Read the answer of a simulator's script."""
        return cls(**answer)

    @property
    def shape(self) -> tuple[int, int]:
        """(H, W) of views, in cells."""
        return self.belief.shape[0] // SCALE, self.belief.shape[1] // SCALE

    @property
    def reach(self) -> float:
        """Cells that a move is long at most where all is free: the radius of a circle with its nearest nodes."""
        return float(np.sqrt(NEIGHBOURS * self.shape[0] * self.shape[1] / np.pi) / LATTICE)

    def moves_of(self, robot: int) -> int:
        """Return how often a robot has moved."""
        return self.step + (robot < self.robot)

    def cell(self, robot: int) -> Cell:
        """Return the cell of a robot in views."""
        row, col = (self.places[robot] // SCALE).tolist()
        return row, col

    def next_node(self, left: NDArray[np.float64]) -> int:
        """Return the node to move to for the cheapest way; ``left`` (N,) are the pixels left from each node at its end.

        Of first moves that cost about the same it is the one after which least is left, as the next map may change the
        way. The robot moves unless there is nowhere to go.
        """
        count = len(self.nodes)
        ends = self.nodes[self.edges]
        lengths = np.hypot(*(ends[:, 0] - ends[:, 1]).T)
        price = SCALE * self.reach
        (one, other), prices = self.edges[lengths > 0].T, lengths[lengths > 0] + price
        finish = np.flatnonzero(np.isfinite(left))
        rows, cols = np.r_[other, np.full(len(finish), count)], np.r_[one, finish]  # from the end back to the robot
        back = csr_array((np.r_[prices, left[finish] + price], (rows, cols)), (count + 1, count + 1))
        to_go = dijkstra(back, indices=[count])[0]
        first = one == self.node
        nodes, costs = other[first], prices[first] + to_go[other[first]]
        if not np.isfinite(costs).any():
            return self.node
        return int(nodes[np.where(costs <= costs.min() + SLACK, to_go[nodes], np.inf).argmin()])


class MoveChooser(SequenceChooser):
    """Choose by sequences where distances count in whole moves, as the simulator counts short moves like long ones.

    The cells with the largest view gains within a move are candidates, too.
    """

    def __init__(self, pilot: CandidatePilot, chooser: SequenceChooser, reach: float) -> None:
        """Take a pilot with its ``chooser``; ``reach`` is the length of a move in lidar ranges."""
        super().__init__(pilot, chooser.parameters, self._candidates_of)
        self._usual, self._reach = chooser.candidates, reach

    def decision_problem(self, view: View, members: list[GroupMember]) -> DecisionProblem:
        """Return the decision problem of a group, with distances in whole moves."""
        problem = super().decision_problem(view, members)
        return problem._replace(away=self._whole(problem.away), between=self._whole(problem.between))

    def _whole(self, distances: NDArray[np.float64]) -> NDArray[np.float64]:
        moves = self._reach * np.ceil(distances / self._reach - 1e-6)
        return np.where(distances < UNREACHABLE, moves, distances)

    def _candidates_of(self, view: View, fields: Distances) -> tuple[NDArray[np.int32], Mask]:
        cells, ahead = self._usual(view, fields)
        reach = self._pilot.briefing.lidar_range
        near = local_candidates(view.belief, fields, reach, int(self._reach * reach), 0.0, LOOKOUTS)
        more = np.setdiff1d(near, cells)
        return np.concatenate([cells, more]), np.concatenate([ahead, np.zeros(len(more), np.bool_)])


class Heard(NamedTuple):
    """What a robot last heard from a teammate."""

    cell: Cell
    moves: int
    """Of the teammate until then."""
    message: Message


class TeamChoice:
    """Choose the nodes of a team with one pilot for each robot, and carry messages between linked ones."""

    def __init__(self, pilots: Sequence[Pilot], first: Turn, budget: int) -> None:
        """Take pilots that were briefed for the shape of the view; all know where the others start."""
        shape = first.shape
        for pilot in pilots:
            chooser = getattr(pilot, "chooser", None)
            if isinstance(pilot, CandidatePilot) and isinstance(chooser, SequenceChooser):
                pilot.chooser = MoveChooser(pilot, chooser, first.reach / pilot.briefing.lidar_range)  # type: ignore[attr-defined]
        self._robots = [RobotChoice(pilot, shape, budget) for pilot in pilots]
        for robot in self._robots:
            robot.heard = {k: Heard(first.cell(k), 0, None) for k in range(len(pilots)) if self._robots[k] is not robot}

    def choose(self, turn: Turn) -> int:
        """Return the node to move to."""
        return self._robots[turn.robot].choose(turn)

    def exchange(self, turn: Turn) -> None:
        """Pass messages on between the robots that were in contact after the last move."""
        for one in turn.linked:
            told = Heard(turn.cell(one), turn.moves_of(one), message_numbers(self._robots[one].message))
            for other in turn.linked:
                if other != one:
                    self._robots[other].heard[one] = told


class RobotChoice:
    """Choose the nodes of one robot."""

    def __init__(self, pilot: Pilot, shape: tuple[int, int], budget: int) -> None:
        self._pilot, self._budget = pilot, budget
        self._visited, self._paths = np.zeros(shape, np.bool_), Paths(shape)
        self._shut: list[tuple[Cell, int]] = []
        self.heard: dict[int, Heard] = {}
        """By teammate."""

    @property
    def message(self) -> Message:
        """The message of the pilot."""
        return self._pilot.message

    def choose(self, turn: Turn) -> int:
        """Return the node to move to; the robot's own to stay."""
        self._shut = [(cell, until) for cell, until in self._shut if until > turn.step]
        cell = turn.cell(turn.robot)
        left = None
        for _ in range(MOST_GOALS):
            belief = self._shown(turn)
            place = self._place(turn, belief, cell)
            if place is None:
                return turn.node
            steps = self._paths.field(belief, place)[tuple((turn.nodes // SCALE).T)]
            left = np.where(steps < UNREACHABLE, SCALE * steps.astype(np.float64), np.inf)
            if left[turn.node] > left.min() or not self._has_goal:
                break
            self._shut.append((place, turn.step + SHUT_MOVES))  # all that nodes show of it has been seen
            self._pilot.act(self._view(turn, self._shown(turn), place))
        assert left is not None
        return turn.next_node(left)

    @property
    def _has_goal(self) -> bool:
        return isinstance(self._pilot, GoalPilot) and self._pilot.goal is not None

    def _place(self, turn: Turn, belief: Belief, cell: Cell) -> Cell | None:
        """Return where the pilot flies to; None if it stays."""
        start = cell
        for move in range(FOLLOWED):
            action = self._pilot.act(self._view(turn, belief, cell))
            moves = action < len(MOVES) and MOVES[action].any()
            ahead = (cell[0] + int(MOVES[action, 0]), cell[1] + int(MOVES[action, 1])) if moves else cell
            if move and isinstance(self._pilot, GoalPilot):  # the second move shows it that the first one did not fail
                path = self._pilot.navigator.path
                return path[-1] if len(path) > 1 else self._pilot.goal
            if ahead == cell or belief[ahead] != FREE:
                break
            cell = ahead
        return cell if cell != start else None

    def _view(self, turn: Turn, belief: Belief, cell: Cell) -> View:
        self._visited[cell] = True
        pace = round(STEPS_A_CELL * turn.reach)
        step = min(turn.step * pace, self._budget - 1)
        mates = tuple(
            Mate(k, heard.cell, (turn.moves_of(k) - heard.moves) * pace, heard.message)
            for k, heard in sorted(self.heard.items())
        )
        legal = read_only(legal_moves(belief, cell))
        return View(belief, cell, legal, step, self._budget, mates, read_only(self._visited.view()))

    def _shown(self, turn: Turn) -> Belief:
        """Return the belief that the pilot is shown, without the unknown cells that no node shows anything of."""
        belief = shown(turn)
        for (row, col), _ in self._shut:
            near = belief[max(0, row - SHUT) : row + SHUT + 1, max(0, col - SHUT) : col + SHUT + 1]
            near[near == UNKNOWN] = OCCUPIED
        return read_only(belief)


def shown(turn: Turn) -> Belief:
    """Return the map of a robot in cells, (H / 4, W / 4) uint8.

    A cell is free if half of its pixels are, or an edge of the graph crosses it, so that all nodes that the robot can
    reach are connected; otherwise it is occupied if a pixel of it is.
    """
    height, width = turn.belief.shape
    parts = turn.belief.reshape(height // SCALE, SCALE, width // SCALE, SCALE)
    belief = np.full((height // SCALE, width // SCALE), UNKNOWN, np.uint8)
    belief[(parts == OCCUPIED).any(axis=(1, 3))] = OCCUPIED
    belief[2 * (parts == FREE).sum(axis=(1, 3)) >= SCALE**2] = FREE
    belief[crossed(turn)] = FREE
    return belief


def crossed(turn: Turn) -> Mask:
    """Return the cells with nodes and those that edges cross, (H / 4, W / 4) bool."""
    found = np.zeros((turn.belief.shape[0] // SCALE, turn.belief.shape[1] // SCALE), np.bool_)
    found[tuple((turn.nodes // SCALE).T)] = True
    ends = turn.nodes[turn.edges].astype(np.float64)
    most = int(np.abs(ends[:, 0] - ends[:, 1]).max(initial=0))
    along = np.linspace(0.0, 1.0, most // 2 + 2)[None, :, None]
    points = np.rint(ends[:, :1] + (ends[:, 1:] - ends[:, :1]) * along).astype(np.int64).reshape(-1, 2) // SCALE
    found[tuple(points.T)] = True
    return found
