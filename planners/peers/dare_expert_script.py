"""Drives the expert planner of DARE in its own process, in the folder of a clone; never imported by this package.

Questions: :func:`begin` an episode, then :func:`plan` at each node. The graph and the planner are those of the clone,
but for what :func:`_faster` replaces. Cells (row, column) of this package are theirs of :func:`scaled` metres; the map
has a rim of obstacles that makes it square, as some of their checks mix up rows and columns.
"""

from __future__ import annotations

import copy
import heapq
import sys
from importlib import import_module
from types import ModuleType
from typing import Any

import numpy as np

#: Obstacles around the map, in cells: their window on it leaves out the outermost ones.
RIM = 4
#: What their maps have for cells that are unknown, free and occupied here.
CODES = np.array([127, 255, 1])
#: The nodes are this share of the lidar range apart, and about this many of their metres.
SHARE, SPACING = 1 / 5, 4.0
#: Sides of the blocks of frontier cells that count once, in lidar ranges.
BLOCK = 0.08

_flight: dict[str, Any] = {}
_known: dict[Any, Any] = {}


def scaled(lidar_range: float) -> tuple[float, dict[str, float]]:
    """Return the metres a cell, and their parameters for a lidar range in cells.

    At 50 cells these are their own: 0.4 m a cell, nodes 4 m apart, a lidar of 20 m. Metres a cell have one decimal, as
    their coordinates are rounded to it.
    """
    apart = max(1, round(SHARE * lidar_range))
    cell = round(SPACING / apart, 1)
    sensor = round(cell * lidar_range, 1)
    block = round(cell * max(1, round(BLOCK * lidar_range)), 1)
    spacing = round(cell * apart, 1)
    names = ("CELL_SIZE", "NODE_RESOLUTION", "FRONTIER_CELL_SIZE", "SENSOR_RANGE", "UTILITY_RANGE", "UPDATING_MAP_SIZE")
    return cell, dict(zip(names, (cell, spacing, block, sensor, 0.8 * sensor, 4 * sensor + 4 * spacing), strict=True))


def begin(lidar_range: float, seed: int) -> dict[str, Any]:
    """Start an episode; the seed is for numpy's global generator, which the planner uses."""
    np.random.seed(seed)  # noqa: NPY002, the generator that their code uses
    cell, parameters = scaled(lidar_range)
    vars(import_module("parameter")).update(parameters)  # before the modules that copy them
    sys.modules["torch"] = ModuleType("torch")  # which only their networks use
    nodes = import_module("classes.agent.node_manager").NodeManager()
    robot = import_module("classes.agent.agent").Agent(0, nodes)
    expert = _faster(import_module("classes.planner.expert_planner")).ExpertPlanner(nodes)
    _flight.update(cell=cell, origin=None, nodes=nodes, robot=robot, expert=expert)
    return {"cell": cell, **parameters}


def plan(belief: np.ndarray, steps: np.ndarray, row: int, col: int) -> dict[str, Any]:
    """Return the cells (K, 2) of the nodes on the way that the planner chooses, none where it has nothing left.

    Away from nodes it plans from the node with the fewest ``steps``, (H, W).
    """
    _known.clear()
    _flight["origin"] = _flight["origin"] or (row, col)  # a node, as in their simulator
    _update(belief, _metres(row, col))
    nodes = {tuple(each.data.coords): each.data for each in _flight["nodes"].nodes_dict}
    useful = sum(node.utility > 0 for node in nodes.values())
    cells = np.array([_cell(key) for key in nodes], np.int32).reshape(-1, 2)
    start = list(nodes)[int(steps[tuple(cells.T)].argmin())] if useful else None
    path = [_cell(key) for key in _path(np.array(start))] if useful else []
    return {"path": np.array(path, np.int32).reshape(-1, 2), "nodes": len(nodes), "useful": useful}


def _update(belief: np.ndarray, location: np.ndarray) -> None:
    """Update the graph from a map as their robot does; a node is visited only where the robot is on it."""
    robot, cell = _flight["robot"], _flight["cell"]
    rows, cols = belief.shape
    square = np.full((max(rows, cols) + 2 * RIM,) * 2, CODES[2])
    square[RIM : RIM + rows, RIM : RIM + cols] = CODES[belief]
    left, top = (-round(cell * (k + RIM), 1) for k in _flight["origin"][::-1])
    robot.update_map(import_module("classes.utils").MapInfo(square, left, top, cell))
    robot.location = location
    if here := _flight["nodes"].nodes_dict.find(location.tolist()):
        here.data.set_visited()
    robot.update_updating_map(location)
    robot.update_frontiers()
    _flight["nodes"].update_graph(location, robot.frontier, robot.updating_map_info, robot.map_info)


def _path(start: np.ndarray) -> list[Any]:
    """Return the planner's nodes after a node; its last tour is forgotten where it has come apart."""
    expert = _flight["expert"]
    for _ in range(2):
        try:
            found: list[list[Any]] = expert.plan_coverage_paths(start[None])
            return found[0] if found else []
        except (AssertionError, IndexError):  # a node of the tour cannot be reached
            expert.last_viewpoints = None
    return []


def _metres(row: int, col: int) -> np.ndarray:
    cell, (first, second) = _flight["cell"], _flight["origin"]
    return np.around(np.array([(col - second) * cell, (row - first) * cell]), 1)


def _cell(point: Any) -> tuple[int, int]:
    cell, (first, second) = _flight["cell"], _flight["origin"]
    return round(point[1] / cell) + first, round(point[0] / cell) + second


def _faster(planner: ModuleType) -> ModuleType:
    """Make copies of sets shallow, and the search for shortest paths one with a heap that remembers its answers."""
    vars(planner)["deepcopy"] = copy.copy
    import_module("classes.agent.node_manager").NodeManager.Dijkstra = _dijkstra
    return planner


def _dijkstra(graph: Any, start: Any) -> tuple[dict[Any, Any], dict[Any, Any]]:
    """Return the length of the shortest path to each node, 1e8 if there is none, and the node before it."""
    source = start[0], start[1]
    if source not in _known:
        _known[source] = _shortest(_known.get("graph") or _known.setdefault("graph", _links(graph)), source)
    away, before = _known[source]
    return away, before


def _links(graph: Any) -> dict[Any, Any]:
    """Return the neighbours of each node with the lengths of the edges, as their code rounds them."""
    nodes = {tuple(each.data.coords): each.data for each in graph.nodes_dict}
    ends = {here: [tuple(end) for end in node.neighbor_list] for here, node in nodes.items()}
    return {
        here: [(end, round(float(np.hypot(end[0] - here[0], end[1] - here[1])), 2)) for end in found if end in nodes]
        for here, found in ends.items()
    }


def _shortest(links: dict[Any, Any], source: Any) -> tuple[dict[Any, Any], dict[Any, Any]]:
    away: dict[Any, Any] = dict.fromkeys(links, np.float64(1e8))
    before: dict[Any, Any] = dict.fromkeys(links)
    away[source] = np.float64(0)
    heap, closed = [(0.0, source)], set()
    while heap:
        length, here = heapq.heappop(heap)
        if here in closed:
            continue
        closed.add(here)
        for end, edge in links[here]:
            if length + edge < away[end]:
                away[end], before[end] = np.float64(length + edge), here
                heapq.heappush(heap, (length + edge, end))
    return away, before
