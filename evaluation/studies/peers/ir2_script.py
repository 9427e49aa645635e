"""Drives the simulator of IR2 in its own process, in the folder of a clone; never imported by this package.

Questions: :func:`begin` an episode, then :func:`move` the robot whose turn it is. Both answer with what that robot
knows. The classes of the simulator run as they are, in the order of its own tests, but for the functions that the end
of this file replaces, which give the same in less time. The inputs of its network are not computed.
"""

from __future__ import annotations

import os
import random
from collections import defaultdict
from functools import lru_cache
from importlib import import_module
from typing import Any

import numpy as np

# The simulator's modules; the settings are first, which tell the others that this is no training.
settings: Any = import_module("test_parameter")
simulator: Any = import_module("env")
graphs: Any = import_module("graph_generator")
viewpoints: Any = import_module("node")

#: Values of the simulator's pixels.
UNKNOWN, FREE = 127, 255
#: Pixels of a wall that a ray sees.
DEPTH = 10
_flight: dict[str, Any] = {}
#: Whether lines are blocked in the true map, and those that are free in the map of a robot.
_walled: dict[Any, bool] = {}
_clear: Any = defaultdict(set)


def begin(part: str, name: str, team: int, most_nodes: int, seed: int, mended: bool) -> dict[str, Any]:
    """Start an episode on a map of a test set; the seed draws the radio's two constants.

    ``most_nodes`` is the size from which global graphs are thinned at every step. ``mended``: a map that several robots
    got at once is copied for each of them, so that no robot writes into the map of another one.
    """
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002, the generator that their code may use
    simulator.TEST_SET_DIR = "DungeonMaps/test/" + part
    graphs.GLOBAL_GRAPH_NODE_COORDS_THRESH = most_nodes
    index = sorted(os.listdir(simulator.TEST_SET_DIR), reverse=True).index(name)  # noqa: PTH208
    for each in (_flight, _walled, _clear):
        each.clear()
    world = simulator.Env(map_index=index, n_agent=team, k_size=settings.K_SIZE, plot=False)
    places = [world.all_node_coords[k][min(k, len(world.all_node_coords[k]) - 1)] for k in range(team)]
    _flight.update(world=world, places=places, robot=0, step=0, index=index, mended=mended, done=False, linked=[0])
    _flight["flown"] = np.zeros(team)
    return _turn()


def move(node: int) -> dict[str, Any]:
    """Move the robot whose turn it is to a node, by its number in the last answer."""
    world, robot, places = _flight["world"], _flight["robot"], _flight["places"]
    target = world.all_node_coords[robot][node]
    length = np.linalg.norm(target - places[robot])
    _flight["flown"][robot] += length
    places[robot] = target
    world.all_robot_positions_belief[robot][robot] = target
    world.all_robot_positions_step_updated[robot][robot] = _flight["step"]
    world.all_rendezvous_utility_inputs[robot] = np.zeros((len(world.all_node_coords[robot]), 1))
    going, _, done = world.single_robot_step(robot, places, _flight["index"], _flight["step"], length)
    if not going:
        raise RuntimeError("the simulator gave up the episode: it found no way in its graph")
    _flight["linked"] = next(group for group in world.group_ids_list if robot in group)
    if _flight["mended"]:
        for k in range(world.n_agent):
            world.all_robot_belief[k][k] = world.all_robot_belief[k][k].copy()
    _flight["robot"] = (robot + 1) % world.n_agent
    if _flight["robot"] == 0:
        _flight["step"] += 1
        _flight["done"] = bool(done)
    return _turn()


def _turn() -> dict[str, Any]:
    """Update the graph of the robot whose turn it is, and return what it knows, in pixels (row, column)."""
    world, robot = _flight["world"], _flight["robot"]
    belief = world.all_robot_belief[robot][robot]
    if not _flight["done"]:
        frontiers = world.find_frontier(world.all_downsampled_belief[robot])
        if not world.update_graph(robot, frontiers, eps=_flight["index"], step=_flight["step"]):
            raise RuntimeError("the simulator gave up the episode: it found no way in its graph")
    nodes = world.all_node_coords[robot]
    number = {tuple(coords): k for k, coords in enumerate(nodes.tolist())}
    edges = world.all_graph[robot]
    return {
        "robot": robot,
        "step": _flight["step"],
        "done": _flight["done"],
        "linked": _flight["linked"],
        "places": np.array(_flight["places"], np.int32)[:, ::-1],
        "flown": _flight["flown"].copy(),
        "explored": np.array([(each[k] == FREE).sum() for k, each in enumerate(world.all_robot_belief)])
        / (world.ground_truth == FREE).sum(),
        "belief": np.where(belief == UNKNOWN, 0, np.where(belief == FREE, 1, 2)).astype(np.uint8),
        "nodes": nodes[:, ::-1].astype(np.int32),
        "edges": _pairs((k, number.get(tuple(end))) for xy, k in number.items() for end in edges.get(xy, ())),
        "node": int(world.find_index_from_coords(_flight["places"][robot], robot)),
    }


def _pairs(found: Any) -> np.ndarray:
    return np.array([pair for pair in found if None not in pair], np.int32).reshape(-1, 2)


@lru_cache(maxsize=1 << 20)
def _line(right: int, down: int) -> Any:
    """Return the pixels (row, column) of a line from (0, 0) as the simulator draws it, without its last one."""
    across, along = abs(right), abs(down)
    error, x, y = across - along, 0, 0
    cells = []
    while (x, y) != (right, down):
        cells.append((y, x))
        if error > 0:
            x += 1 if right > 0 else -1
            error -= 2 * along
        else:
            y += 1 if down > 0 else -1
            error += 2 * across
    return np.array(cells, np.int64).reshape(-1, 2)


@lru_cache(maxsize=1 << 20)
def _flat_line(right: int, down: int, width: int) -> Any:
    return _line(right, down) @ np.array([width, 1])


def _blocked(self: Any, start: Any, end: Any, belief: np.ndarray) -> bool:
    """Return what ``check_collision`` does: whether a line meets a pixel that is not free before its end.

    A line that is blocked in the true map is blocked in all others, and one that was free in a robot's map stays so.
    """
    x, y, u, v = key = int(start[0]), int(start[1]), int(end[0]), int(end[1])
    clear = _clear[getattr(self, "robot_id", -1)]
    if key in clear:
        return False
    if key not in _walled and _flight:
        _walled[key] = _meets(_flight["world"].ground_truth, x, y, u - x, v - y)
    if _walled.get(key):
        return True
    blocked = _meets(belief, x, y, u - x, v - y)
    if not blocked and hasattr(self, "robot_id"):
        clear.add(key)
    return blocked


def _meets(pixels: np.ndarray, x: int, y: int, right: int, down: int) -> bool:
    width = pixels.shape[1]
    return bool(pixels.ravel()[_flat_line(right, down, width) + (y * width + x)].min(initial=FREE) < FREE)


def _join(self: Any, nodes: np.ndarray, coords: Any, belief: np.ndarray, global_graph: Any = None) -> list[Any]:
    """Do what ``find_k_neighbor`` does: join a node to the global graph's neighbours and to the nearest nodes."""
    here = tuple(coords)
    ends = {} if global_graph is None else global_graph.edges.get(here, {})
    far = [edge for edge in ends.values() if settings.CUR_AGENT_KNN_RAD < edge.length <= settings.GLOBAL_GRAPH_KNN_RAD]
    order = np.argsort(np.array([edge.length for edge in far]))[: self.k_size]
    joined = {tuple(far[k].to_node) for k in order}
    for end in joined:
        self.graph.add_node(here)
        self.graph.add_edge(here, end, np.linalg.norm(coords - end))
    return _join_nearest(self, self.graph, nodes, coords, belief, joined, np.inf)


def _join_global(self: Any, nodes: np.ndarray, coords: Any, belief: np.ndarray, graph: Any, **how: Any) -> list[Any]:
    """Do what ``find_k_neighbor_custom`` does as the simulator calls it: join a node to the nearest ones in reach."""
    graph = graph if how.get("modify_graph", True) else None
    return _join_nearest(self, graph, nodes, np.asarray(coords), belief, set(), how["max_edge_len"])


def _join_nearest(self: Any, graph: Any, nodes: Any, coords: Any, belief: Any, joined: Any, reach: float) -> list[Any]:
    lengths = np.linalg.norm(nodes - coords, axis=1)
    order: Any = np.argsort(lengths)
    here, start, count = tuple(coords), tuple(coords.tolist()), 0
    clear = _clear[self.robot_id]
    ends = nodes[order].tolist()
    most = min(len(nodes), self.k_size - len(joined))
    for met, k in enumerate(order):
        end = tuple(ends[met])
        if end in joined:
            continue
        count += 1
        if lengths[k] > reach:
            continue  # to the last node, as theirs
        line = start + end
        if graph is not None and (line in clear or not (_walled.get(line) or _blocked(self, start, end, belief))):
            graph.nodes.add(here)
            graph.edges.setdefault(here, {})[end] = _Edge(end, lengths[k])
        if count >= most:
            return list(order[: met + 1])
    return list(order)


@lru_cache(maxsize=1 << 20)
def _rays(reach: float) -> Any:
    """Return the pixels of all rays of a lidar at (0, 0), (rays, most pixels, 2), and the length of each."""
    angle, lines = 0.0, []
    while angle < 2 * np.pi:
        lines.append(_line(int(np.round(np.cos(angle) * reach)), int(np.round(np.sin(angle) * reach))))
        angle += 0.5 / 180 * np.pi
    rays = np.zeros((len(lines), max(map(len, lines)), 2), np.int64)
    for ray, line in zip(rays, lines):  # noqa: B905, of Python 3.10
        ray[: len(line)] = line
        ray[len(line) :] = line[-1]
    return rays, np.array([len(line) for line in lines])


def _scan(place: Any, reach: float, belief: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Do what ``sensor_work`` does: write into a map what a lidar sees, up to ten pixels deep into walls."""
    rays, lengths = _rays(reach)
    rows, columns = rays[..., 0] + int(place[1]), rays[..., 1] + int(place[0])
    inside = (rows >= 0) & (rows < truth.shape[0]) & (columns >= 0) & (columns < truth.shape[1])
    rows, columns = rows.clip(0, truth.shape[0] - 1), columns.clip(0, truth.shape[1] - 1)
    wall = inside & (truth[rows, columns] == 1)
    walls = wall.cumsum(axis=1)
    ends = ~inside | (wall & (walls >= DEPTH)) | (~wall & (walls > 0)) | (np.arange(rays.shape[1]) >= lengths[:, None])
    seen = ~np.logical_or.accumulate(ends, axis=1)
    belief[rows[seen], columns[seen]] = truth[rows[seen], columns[seen]]
    return belief


def _copied(self: Any, _: Any) -> Any:
    """Return a copy of a graph that shares its edges, which nothing changes."""
    copy = type(self)()
    copy.nodes, copy.edges = set(list(self.nodes)), {node: dict(edges) for node, edges in self.edges.items()}
    return copy


_Edge = import_module("graph").Edge
_Edge.__deepcopy__ = lambda self, _: self
graphs.Graph.__deepcopy__ = _copied
simulator.sensor_work = _scan
graphs.Graph_generator.check_collision = _blocked
viewpoints.Node.check_collision = _blocked
graphs.Graph_generator.find_k_neighbor = _join
graphs.Graph_generator.find_k_neighbor_custom = _join_global
