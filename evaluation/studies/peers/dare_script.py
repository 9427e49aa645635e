"""Drives the simulator of DARE in its own process, in the folder of a clone; never imported by this package.

Questions: :func:`begin` an episode, then :func:`step` to a node or to the one that the expert planner chooses. Both
answer with the state of the simulator, whose classes run as they are.
"""

from __future__ import annotations

import os
from copy import deepcopy
from typing import Any

import numpy as np
from classes.agent.agent import Agent
from classes.agent.node_manager import NodeManager
from classes.env.env import Env
from classes.planner.expert_planner import ExpertPlanner
from classes.utils import get_cell_position_from_coords
from parameter import CELL_SIZE, FREE, OCCUPIED

_flight: dict[str, Any] = {}


def begin(name: str, seed: int) -> dict[str, Any]:
    """Start an episode on a map of ``maps_test``; the seed is for numpy's global generator, which the expert uses."""
    np.random.seed(seed)  # noqa: NPY002, the generator that their code uses
    env, graph = Env(sorted(os.listdir("maps_test")).index(name), test=True), NodeManager()  # noqa: PTH208
    _flight.update(env=env, robot=Agent(0, graph), graph=graph, expert=ExpertPlanner(graph))
    return _state()


def step(node: int | None, on_the_way: bool = False) -> dict[str, Any]:
    """Move to a node by its number in the last state, None for the one that the expert planner chooses.

    ``on_the_way``: scan in every cell that the straight line to it passes, and not at its end alone.
    """
    env = _flight["env"]
    if node is None:
        target = np.array(_flight["expert"].plan_coverage_paths(env.robot_locations)[0][0])
    else:
        target = _flight["nodes"][node].coords
    if on_the_way:
        for cell in _passed(env.robot_locations[0], target):
            env.update_robot_belief(cell)
    env.step(target, 0)
    return _state()


def _state() -> dict[str, Any]:
    """Update the robot's graph as their own loop does, and return it with the map, in cells (row, column)."""
    env, robot = _flight["env"], _flight["robot"]
    robot.update_graph(env.belief_info, deepcopy(env.robot_locations[0]))
    nodes = _flight["nodes"] = [each.data for each in _flight["graph"].nodes_dict]
    number = {tuple(node.coords): k for k, node in enumerate(nodes)}
    frontiers = sorted({point for node in nodes for point in node.observable_frontiers})
    place = {point: k for k, point in enumerate(frontiers)}
    belief = env.robot_belief
    return {
        "belief": (1 * (belief == FREE) + 2 * (belief == OCCUPIED)).astype(np.uint8),
        "nodes": _cells([node.coords for node in nodes]),
        "edges": _pairs((k, number.get(tuple(end))) for k, node in enumerate(nodes) for end in node.neighbor_list),
        "utility": np.array([node.utility for node in nodes], np.int32),
        "frontiers": _cells(frontiers),
        "sights": _pairs((k, place[point]) for k, node in enumerate(nodes) for point in node.observable_frontiers),
        "node": number[tuple(env.robot_locations[0])],
        "metres": float(robot.travel_dist),
        "explored": float((belief == FREE).sum() / (env.ground_truth == FREE).sum()),
        "done": sum(node.utility for node in nodes) == 0,
    }


def _passed(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the cells between two places in metres, (K, 2), as (column, row), which their functions have."""
    count = int(np.ceil(np.abs(end - start).max() / CELL_SIZE))
    return _cells(list(np.linspace(start, end, 1 + count)[1:-1]))[:, ::-1]


def _cells(points: Any) -> np.ndarray:
    if not points:
        return np.empty((0, 2), np.int32)
    cells = get_cell_position_from_coords(np.array(points), _flight["env"].belief_info)
    return np.asarray(cells.reshape(-1, 2)[:, ::-1], np.int32)


def _pairs(found: Any) -> np.ndarray:
    return np.array(sorted(pair for pair in found if None not in pair), np.int32).reshape(-1, 2)
