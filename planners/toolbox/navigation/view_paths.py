"""Paths that see much on the way, for UAVs with a limited field of view.

FUEL plans the yaw along a path by a graph search (B. Zhou et al., RA-L 2021, doi:10.1109/LRA.2021.3051563). Here, where
moves decide the heading, a beam search over moves and turns looks for the way to a goal that shows the most unknown
cells, each counted once. A way may be some steps longer than a shortest one where these steps pay.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import FREE, MOVES, UNREACHABLE
from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.search.bfs import distances_from
from indoor_explorers.env.sensing.field_of_view import is_in_view
from indoor_explorers.env.sensing.lidar import Scan, new_scan, visible_cells
from indoor_explorers.planners.toolbox.information.camera import Camera

#: Choices of a step: the four moves, and a turn.
CHOICES, TURNING = 5, 4
#: Ways to one cell and heading whose scores differ by less count as alike.
LIKE = 1e-9


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
    """(P + 1,) how many cells each has; the last one is the number of poses."""


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


class _Task(NamedTuple):
    """What is searched."""

    belief: np.ndarray
    value: np.ndarray
    camera: Camera
    goal: int
    left: np.ndarray
    """(H*W,) steps to the goal."""
    parameters: WayParameters


class _Memory(NamedTuple):
    """Working arrays of a search."""

    ways: _Ways
    views: _Views
    stamps: np.ndarray
    """(H*W,) number + 1 of the last way that shows a cell."""
    scan: Scan


@kernel(entry=False)
def _new_memory(task: _Task) -> _Memory:
    size, disc = task.belief.size, task.camera.lidar.disc
    most = 1 + task.parameters.horizon * task.parameters.width * CHOICES
    ways = _Ways(np.empty(most, np.int64), np.empty(most, np.int64), np.full(most, -1), np.zeros(most))
    views = _Views(np.full((size, 4), -1, np.int32), np.empty((most, disc), np.int32), np.zeros(most + 1, np.int64))
    return _Memory(ways, views, np.zeros(size, np.int64), new_scan(task.camera.lidar))


@kernel(entry=False)
def _extend(task: _Task, memory: _Memory, way: int, longest: int, count: int) -> int:
    """Add the ways that continue one and have at most ``longest`` steps left; return the new number of ways."""
    ways, views, stamps, scan = memory
    here = ways.cell[way]
    _mark(ways, views, way, stamps)
    for choice in _by_longer_axis(task.belief.shape, here, task.goal):
        cell, heading = _after(task.belief, here, ways.heading[way], choice)
        if cell < 0 or task.left[cell] > longest:
            continue
        view, gain = _view(task.belief, task.value, task.camera, scan, views, cell, heading), 0.0
        for place in range(views.sizes[view]):
            if stamps[views.cells[view, place]] != way + 1:
                gain += task.value[views.cells[view, place]]
        ways.cell[count], ways.heading[count], ways.parent[count] = cell, heading, way
        ways.score[count] = ways.score[way] + gain - task.parameters.price * (1 + task.left[cell] - task.left[here])
        count += 1
    return count


@kernel(entry=False)
def _kept(task: _Task, ways: _Ways, first: int, count: int) -> np.ndarray:
    """Return the best of the ways from ``first`` on that have not arrived, those with like ends once."""
    layer, kept = np.empty(task.parameters.width, np.int64), 0
    for place in np.argsort(-ways.score[first:count], kind="mergesort"):
        way = first + place
        fresh = task.left[ways.cell[way]] > 0 and kept < layer.shape[0]
        for other in layer[:kept]:
            same = ways.cell[other] == ways.cell[way] and ways.heading[other] == ways.heading[way]
            fresh &= not (same and abs(ways.score[other] - ways.score[way]) < LIKE)
        if fresh:
            layer[kept] = way
            kept += 1
    return layer[:kept]


@kernel(entry=False)
def _search(task: _Task, start: tuple[int, int]) -> np.ndarray:
    """Return the flat cells of the best way's planned part, (T + 1,), and the heading at its end."""
    memory, horizon = _new_memory(task), task.parameters.horizon
    ways = memory.ways
    ways.cell[0], ways.heading[0] = start
    best, most, layer, count = 0, -np.inf, np.zeros(1, np.int64), 1
    for step in range(1, horizon + 1):
        first = count
        for way in layer:
            count = _extend(task, memory, way, task.left[start[0]] + task.parameters.slack - step, count)
        for way in range(first, count):
            if (step == horizon or task.left[ways.cell[way]] == 0) and ways.score[way] > most:
                best, most = way, ways.score[way]
        layer = _kept(task, ways, first, count)
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
    goal: int,
    parameters: WayParameters,
) -> np.ndarray:
    field = np.empty(belief.shape, np.int32)
    distances_from(belief, goal // belief.shape[1], goal % belief.shape[1], np.empty(belief.size, np.int32), field)
    left = field.reshape(belief.size)
    if left[start[0]] >= UNREACHABLE:
        return np.empty(0, np.int64)
    planned = _search(_Task(belief, value, camera, goal, left, parameters), start)
    cell, planned = planned[-2], planned[:-1]
    out = np.empty(planned.shape[0] + left[cell], np.int64)
    out[: planned.shape[0]] = planned
    for place in range(planned.shape[0], out.shape[0]):
        for choice in _by_longer_axis(belief.shape, cell, goal):
            following = _after(belief, cell, 0, choice)[0]
            if following >= 0 and left[following] == left[cell] - 1:
                cell = following
                break
        out[place] = cell
    return out


def view_path(
    belief: Belief,
    value: np.ndarray,
    camera: Camera,
    start: tuple[Cell, int],
    goal: Cell,
    parameters: WayParameters,
) -> list[Cell]:
    """Return a way on a (H, W) belief from a cell and heading to a goal, both included; empty if there is none.

    A cell that follows itself is a turn. ``value`` (H*W,) is that of unknown
    cells, and 0 elsewhere.
    """
    width = belief.shape[1]
    (row, col), facing = start
    way = _way(belief, value, camera, (row * width + col, facing), goal[0] * width + goal[1], parameters)
    return [divmod(place, width) for place in way.tolist()]
