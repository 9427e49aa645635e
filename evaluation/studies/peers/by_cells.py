"""Pilots on the graph of another simulator, by cells: any policy, shown a grid, and taken to the node for its goal.

The view has cells of twice the simulator's size. Its frontier is the simulator's: unknown cells beside free ones count
as obstacles unless a frontier point that the simulator counts is near, so that nothing else attracts the pilot. Where
the pilot flies to is its goal if it has one (:class:`GoalPilot`), else where its moves lead while the map stays as it
is. The robot then moves to the node with the least way to it from which frontier points near that place are in view.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, distance_transform_edt

from indoor_explorers.env.grid.arrays import Belief, Cell, Mask, read_only
from indoor_explorers.env.grid.cells import FREE, MOVES, OCCUPIED, UNKNOWN, UNREACHABLE
from indoor_explorers.env.interfaces.ros import legal_moves
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.view import View
from indoor_explorers.evaluation.studies.peers.graph import GraphState
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot
from indoor_explorers.planners.toolbox.navigation.paths import Paths

#: Cells of the simulator along the side of a cell of the view.
SCALE = 2
#: Distance from a counted frontier point, in cells of the simulator, within which unknown cells stay unknown.
OPEN = 4.0
#: Distance from the pilot's goal, in cells of the simulator, within which a frontier point is taken to be meant.
MEANT = 6.0
#: Most moves that a pilot without a goal is followed.
FOLLOWED = 25


class CellChoice:
    """Show a pilot the simulator's map as a grid, and choose the node for the place it flies to."""

    def __init__(self, pilot: Pilot, shape: tuple[int, int], budget: int) -> None:
        """Take a pilot that was briefed for the ``shape`` of the view; ``budget`` is that of its views."""
        self._pilot, self._budget, self._step = pilot, budget, 0
        self._visited = np.zeros(shape, np.bool_)
        self._paths = Paths(shape)

    def choose(self, state: GraphState) -> int:
        """Return the node to fly to."""
        belief = shown(state)
        row, col = (np.array(state.cell(state.node)) // SCALE).tolist()
        place = self._place(belief, (row, col))
        steps = self._paths.field(belief, place)
        rows, cols = (state.nodes[state.useful] // SCALE).T
        to_place = np.where(steps[rows, cols] < UNREACHABLE, steps[rows, cols], belief.size)
        apart = np.hypot(*(state.frontiers - SCALE * np.array(place)).T)
        meant = state.in_view[state.useful][:, apart <= max(MEANT, apart.min(initial=np.inf))].any(axis=1)
        costs = state.away[state.useful] + 1e-3 * to_place
        if not meant.any():
            meant, costs = np.ones_like(meant), costs + SCALE * state.resolution * to_place
        return int(state.useful[np.where(meant, costs, np.inf).argmin()])

    def _place(self, belief: Belief, cell: Cell) -> Cell:
        """Return where the pilot flies to."""
        goal: Cell | None = None
        for _ in range(FOLLOWED):
            action = self._pilot.act(self._view(belief, cell))
            moves = action < len(MOVES) and MOVES[action].any()
            ahead = (cell[0] + int(MOVES[action, 0]), cell[1] + int(MOVES[action, 1])) if moves else cell
            if goal is None and isinstance(self._pilot, GoalPilot):
                goal = self._pilot.goal
            elif goal is not None or ahead == cell or belief[ahead] != FREE:
                break  # of a pilot with a goal after its second move, which shows it that the first one did not fail
            cell = ahead
        return goal or cell

    def _view(self, belief: Belief, cell: Cell) -> View:
        self._visited[cell] = True
        self._step += 1
        legal = read_only(legal_moves(belief, cell))
        visited = read_only(self._visited)
        return View(belief, cell, legal, min(self._step, self._budget) - 1, self._budget, (), visited)


def shown_shape(shape: tuple[int, ...]) -> tuple[int, int]:
    """Return the (H, W) of the view for that of the simulator's map."""
    height, width = (-(-length // SCALE) for length in shape)
    return height, width


def shown(state: GraphState) -> Belief:
    """Return the belief that a pilot is shown, uint8 of :func:`shown_shape`.

    A cell is free if half of its part of the map is, or an edge of the graph crosses it, so that all nodes that the
    robot can reach are connected.
    """
    height, width = shown_shape(state.belief.shape)
    (rows, cols), end = state.belief.shape, (height * SCALE, width * SCALE)
    whole = np.pad(state.belief, ((0, end[0] - rows), (0, end[1] - cols)))
    parts = whole.reshape(height, SCALE, width, SCALE)
    belief = np.full((height, width), UNKNOWN, np.uint8)
    belief[(parts == OCCUPIED).any(axis=(1, 3))] = OCCUPIED
    belief[2 * (parts == FREE).sum(axis=(1, 3)) >= SCALE**2] = FREE
    belief[tuple(_crossed(state).T)] = FREE
    unknown = belief == UNKNOWN
    belief[unknown & _beside(belief == FREE) & ~_near(state, belief.shape)] = OCCUPIED
    return read_only(belief)


def _crossed(state: GraphState) -> NDArray[np.int64]:
    """Return the cells that edges cross, (K, 2)."""
    ends = state.nodes[state.edges]
    most = int(np.abs(ends[:, 0] - ends[:, 1]).max(initial=0))
    along = np.linspace(0.0, 1.0, most + 1)[None, :, None]
    points = ends[:, :1] + (ends[:, 1:] - ends[:, :1]) * along
    return np.asarray(np.rint(points).astype(np.int64).reshape(-1, 2) // SCALE)


def _beside(cells: Mask) -> Mask:
    return np.asarray(binary_dilation(cells, np.ones((3, 3), np.bool_)))


def _near(state: GraphState, shape: tuple[int, ...]) -> Mask:
    """Return which cells are near a counted frontier point."""
    points = np.ones(shape, np.bool_)
    points[tuple((state.frontiers // SCALE).T)] = False
    return np.asarray(SCALE * distance_transform_edt(points) <= OPEN) & (len(state.frontiers) > 0)
