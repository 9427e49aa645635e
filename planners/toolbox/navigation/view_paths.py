"""Paths that see much on the way, for UAVs with a limited field of view.

FUEL plans the yaw along a path by a graph search (B. Zhou et al., RA-L 2021, doi:10.1109/LRA.2021.3051563). Here, where
moves decide the heading, a beam search over moves and turns looks for the way to a pose that shows the most unknown
cells, each counted once. A way may be some steps longer than a shortest one where these steps pay.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import FREE, MOVES, UNREACHABLE
from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.sensing.field_of_view import is_in_view
from indoor_explorers.env.sensing.lidar import Scan, new_scan, visible_cells
from indoor_explorers.planners.toolbox.information.pose_views import Camera
from indoor_explorers.planners.toolbox.navigation.poses import ANY, steps_left

#: Choices of a step: the four moves, and a turn.
CHOICES, TURNING = 5, 4


class WayParameters(NamedTuple):
    """What a way is worth, and how many are compared."""

    price: float
    """Value that each step more than on a shortest path has to show."""
    slack: int
    """Most steps more than on a shortest path."""
    horizon: int
    """Steps that are planned; a shortest path follows."""
    width: int
    """Ways kept at each step."""


class _Ways(NamedTuple):
    """Ways as a tree of poses, layer by layer."""

    cell: np.ndarray
    heading: np.ndarray
    parent: np.ndarray
    """Number of the pose before; -1 at the start."""
    score: np.ndarray
    """Value seen on the way, minus the price of additional steps."""


class _Views(NamedTuple):
    """The cells of value that poses show."""

    number: np.ndarray
    """(H*W, 4) number of a pose, -1 for one that has not been looked at."""
    cells: np.ndarray
    """(P, disc) flat cells."""
    sizes: np.ndarray
    """(P + 1,) how many; the last one is the number of poses."""


@leaf(entry=False)
def _steps_left(left: np.ndarray, goal: tuple[int, int], cell: int, heading: int) -> int:
    """Return the steps from a pose to the goal's."""
    steps = left[cell // left.shape[1], cell % left.shape[1]]
    if cell == goal[0]:
        steps = min(steps, np.int32(0 if goal[1] == ANY else (goal[1] - heading) % 4))
    return int(steps)


@leaf(entry=False)
def _view(
    belief: np.ndarray, value: np.ndarray, camera: Camera, scan: Scan, views: _Views, cell: int, heading: int
) -> int:
    """Return the number of a pose's view, which is looked up once."""
    if views.number[cell, heading] < 0:
        new = views.sizes[-1]
        views.number[cell, heading] = new
        views.sizes[-1] += 1
        row, col = divmod(cell, belief.shape[1])
        for place in range(1, visible_cells(belief, row, col, camera.lidar, scan)):
            other = scan.cells[place]
            down, right = other // belief.shape[1] - row, other % belief.shape[1] - col
            if value[other] > 0.0 and is_in_view(camera.least_cosine, heading, down, right):
                views.cells[new, views.sizes[new]] = other
                views.sizes[new] += 1
    return int(views.number[cell, heading])


@leaf(entry=False)
def _mark(ways: _Ways, views: _Views, way: int, stamps: np.ndarray) -> None:
    """Stamp the cells that a way shows with its number + 1."""
    at = way
    while ways.parent[at] >= 0:
        view = views.number[ways.cell[at], ways.heading[at]]
        for place in range(views.sizes[view]):
            stamps[views.cells[view, place]] = way + 1
        at = ways.parent[at]


@leaf(entry=False)
def _after(belief: np.ndarray, cell: int, heading: int, choice: int) -> tuple[int, int]:
    """Return the pose after a choice; its cell is -1 for a move that is not open."""
    if choice == TURNING:
        return cell, (heading + 1) % 4
    row, col = cell // belief.shape[1] + MOVES[choice, 0], cell % belief.shape[1] + MOVES[choice, 1]
    if 0 <= row < belief.shape[0] and 0 <= col < belief.shape[1] and belief[row, col] == FREE:
        return row * belief.shape[1] + col, choice
    return -1, choice


@kernel(entry=False)
def _by_longer_axis(shape: tuple[int, int], cell: int, goal: int) -> np.ndarray:
    """Return the moves, those first that reduce the longer axis to the goal, and then the turn, (5,)."""
    down, right = goal // shape[1] - cell // shape[1], goal % shape[1] - cell % shape[1]
    longer = np.full(CHOICES, shape[0] + shape[1])
    for choice in range(TURNING):
        longer[choice] = max(abs(down - MOVES[choice, 0]), abs(right - MOVES[choice, 1]))
    return np.argsort(longer, kind="mergesort")


@kernel(entry=False)
def _search(
    belief: np.ndarray,
    value: np.ndarray,
    camera: Camera,
    start: tuple[int, int],
    goal: tuple[int, int],
    left: np.ndarray,
    parameters: WayParameters,
) -> np.ndarray:
    """Return the flat cells of the best way's planned part, (T + 1,), the heading at its end last."""
    price, slack, horizon, width = parameters
    most = 1 + horizon * width * CHOICES
    ways = _Ways(np.empty(most, np.int64), np.empty(most, np.int64), np.full(most, -1), np.zeros(most))
    ways.cell[0], ways.heading[0] = start
    views = _Views(
        np.full((belief.size, 4), -1, np.int32),
        np.empty((most, camera.lidar.disc), np.int32),
        np.zeros(most + 1, np.int64),
    )
    stamps, scan = np.zeros(belief.size, np.int64), new_scan(camera.lidar)
    shortest = _steps_left(left, goal, start[0], start[1])
    best, best_score, layer, count = 0, -np.inf, np.zeros(1, np.int64), 1
    for step in range(1, horizon + 1):
        first = count
        for way in layer:
            _mark(ways, views, way, stamps)
            for choice in _by_longer_axis(belief.shape, ways.cell[way], goal[0]):
                cell, heading = _after(belief, ways.cell[way], ways.heading[way], choice)
                if cell < 0:
                    continue
                extra = step + _steps_left(left, goal, cell, heading) - shortest
                if extra > slack:
                    continue
                view, gain = _view(belief, value, camera, scan, views, cell, heading), 0.0
                for place in range(views.sizes[view]):
                    if stamps[views.cells[view, place]] != way + 1:
                        gain += value[views.cells[view, place]]
                spent = step - 1 + _steps_left(left, goal, ways.cell[way], ways.heading[way]) - shortest
                ways.cell[count], ways.heading[count], ways.parent[count] = cell, heading, way
                ways.score[count] = ways.score[way] + gain - price * (extra - spent)
                count += 1
        layer, kept = np.empty(width, np.int64), 0
        for place in np.argsort(-ways.score[first:count], kind="mergesort"):
            way, fresh = first + place, True
            for other in layer[:kept]:
                same = ways.cell[other] == ways.cell[way] and ways.heading[other] == ways.heading[way]
                fresh &= not (same and abs(ways.score[other] - ways.score[way]) < 1e-9)
            arrived = _steps_left(left, goal, ways.cell[way], ways.heading[way]) == 0
            if (arrived or step == horizon) and ways.score[way] > best_score:
                best, best_score = way, ways.score[way]
            if fresh and not arrived and kept < width:
                layer[kept] = way
                kept += 1
        layer = layer[:kept]
    return _traced(ways, best)


@kernel(entry=False)
def _traced(ways: _Ways, way: int) -> np.ndarray:
    """Return the cells of a way, and the heading at its end."""
    length, at = 1, way
    while ways.parent[at] >= 0:
        length, at = length + 1, ways.parent[at]
    out = np.empty(length + 1, np.int64)
    out[length] = ways.heading[way]
    for place in range(length - 1, -1, -1):
        out[place] = ways.cell[way]
        way = ways.parent[way]
    return out


@kernel()
def _way(
    belief: np.ndarray,
    value: np.ndarray,
    camera: Camera,
    start: tuple[int, int],
    goal: tuple[int, int],
    parameters: WayParameters,
) -> np.ndarray:
    left = steps_left(belief, goal[0], goal[1])
    if _steps_left(left, goal, start[0], start[1]) >= UNREACHABLE:
        return np.empty(0, np.int64)
    planned = _search(belief, value, camera, start, goal, left, parameters)
    cell, heading = planned[-2], planned[-1]
    rest = _steps_left(left, goal, cell, heading)
    out = np.empty(planned.shape[0] - 1 + rest, np.int64)
    out[: planned.shape[0] - 1] = planned[:-1]
    for place in range(planned.shape[0] - 1, out.shape[0]):
        for choice in _by_longer_axis(belief.shape, cell, goal[0]):
            following, faced = _after(belief, cell, heading, choice)
            if following >= 0 and _steps_left(left, goal, following, faced) == out.shape[0] - 1 - place:
                cell, heading = following, faced
                break
        out[place] = cell
    return out


def view_path(
    belief: Belief,
    value: np.ndarray,
    camera: Camera,
    start: tuple[Cell, int],
    goal: tuple[Cell, int],
    parameters: WayParameters,
) -> list[Cell]:
    """Return a way on a (H, W) belief from one pose to another, both included; empty if there is none.

    A cell that follows itself is a turn. The heading of the goal may be ``ANY``. ``value`` (H*W,) is that of unknown
    cells, and 0 elsewhere.
    """
    width = belief.shape[1]
    (row, col), facing = start
    (goal_row, goal_col), heading = goal
    way = _way(belief, value, camera, (row * width + col, facing), (goal_row * width + goal_col, heading), parameters)
    return [divmod(place, width) for place in way.tolist()]
