"""A small simulator of the kind that graph-based explorers use, with numpy alone; also a script for a peer's process.

Three rooms in a row, 4 m between nodes, a robot that sees 8 m and jumps between nodes.
"""

from __future__ import annotations

import os
import sys
from typing import Any

import numpy as np

CELLS, REACH, VIEW = 10, 20, 16
WORLD = np.full((41, 121), 1, np.uint8)
WORLD[0] = WORLD[-1] = WORLD[:, 0] = WORLD[:, -1] = 2
WORLD[:, 40] = WORLD[:, 80] = 2
WORLD[18:23, 40] = WORLD[28:33, 80] = 1
_flight: dict[str, Any] = {}


def begin(name: str, seed: int) -> dict[str, Any]:
    """Start an episode."""
    if os.environ.get("FAILS_ON") == name:
        sys.stdout.write("no memory for the map\n")
        sys.stdout.flush()
        os._exit(7)
    _flight.update(belief=np.zeros_like(WORLD), at=(20, 10), metres=0.0, visited=set())
    return _state()


def step(node: int | None, on_the_way: bool) -> dict[str, Any]:
    """Move to a node, None for the nearest one of some use, and see what is in range there, or on the way."""
    nodes, useful = _flight["nodes"], np.flatnonzero(_flight["utility"])
    if node is None:
        way = _ways()[useful]
        goal = int(useful[way.argmin()])
        while _flight["before"][goal] != _flight["node"]:
            goal = _flight["before"][goal]
        node = goal
    assert [_flight["node"], node] in _flight["edges"].tolist()
    _flight["metres"] += 0.4 * float(np.hypot(*(nodes[node] - nodes[_flight["node"]])))
    passed = np.linspace(_flight["at"], nodes[node], 1 + CELLS)[1:-1].round().astype(int)
    for cell in passed if on_the_way else ():
        _scan(tuple(cell.tolist()))
    _flight["at"] = tuple(nodes[node].tolist())
    return _state()


def _scan(at: Any) -> None:
    belief = _flight["belief"]
    cells = np.argwhere(np.hypot(*(np.indices(WORLD.shape) - np.array(at)[:, None, None])) <= REACH)
    seen = cells[_clear(WORLD, at, cells)]
    belief[tuple(seen.T)] = WORLD[tuple(seen.T)]


def _clear(belief: np.ndarray, start: Any, ends: np.ndarray) -> np.ndarray:
    """Return which of (K, 2) cells are in sight of one, whatever they are themselves."""
    share = np.linspace(0, 1, 2 * REACH)[None, :, None]
    line = np.rint(np.array(start) + (ends - np.array(start))[:, None] * share).astype(int)
    inside = (line == ends[:, None]).all(axis=2)
    return np.asarray(((belief[line[..., 0], line[..., 1]] == 1) | inside).all(axis=1))


def _state() -> dict[str, Any]:
    belief, at = _flight["belief"], _flight["at"]
    _flight["visited"].add(at)
    _scan(at)
    lattice = np.argwhere(np.ones((5, 13))) * CELLS
    nodes = lattice[belief[tuple(lattice.T)] == 1]
    unknown = np.pad(belief == 0, 1)
    beside = sum(unknown[1 + i : 42 + i, 1 + j : 122 + j] for i in (-1, 0, 1) for j in (-1, 0, 1))
    points = np.argwhere((belief == 1) & (beside > 1))
    edges, sights = list[list[int]](), list[list[int]]()
    for k, node in enumerate(nodes):
        near = np.flatnonzero(np.abs(nodes - node).max(axis=1) <= CELLS)
        edges += [[k, int(j)] for j in near[_clear(belief, node, nodes[near])]]
        far = np.flatnonzero(np.hypot(*(points - node).T) <= VIEW)
        if tuple(node.tolist()) not in _flight["visited"] and len(far):
            sights += [[k, int(j)] for j in far[_clear(belief, node, points[far])]]
    pairs = np.array(sights, np.int32).reshape(-1, 2)
    utility = np.bincount(pairs[:, 0], minlength=len(nodes)).astype(np.int32)
    here = int(np.flatnonzero((nodes == at).all(axis=1))[0])
    _flight.update(nodes=nodes, edges=np.array(edges), utility=utility, node=here)
    utility = _flight["utility"] = np.where(np.isfinite(_ways()), utility, 0)
    return {
        "belief": belief.copy(),
        "nodes": nodes.astype(np.int32),
        "edges": np.array(edges, np.int32),
        "utility": utility,
        "frontiers": points.astype(np.int32),
        "sights": pairs,
        "node": here,
        "metres": _flight["metres"],
        "explored": float((belief == 1).sum() / (WORLD == 1).sum()),
        "done": int(utility.sum()) == 0,
    }


def _ways() -> np.ndarray:
    """Return the metres from the robot to the nodes, and keep the nodes before."""
    nodes, (starts, ends) = _flight["nodes"], _flight["edges"].T
    away, before = np.full(len(nodes), np.inf), np.full(len(nodes), -1)
    away[_flight["node"]] = 0.0
    lengths = 0.4 * np.hypot(*(nodes[starts] - nodes[ends]).T)
    for _ in nodes:
        found = away[starts] + lengths
        order = np.argsort(-found, kind="stable")  # the shortest is written last
        better = order[found[order] < away[ends[order]] - 1e-9]
        if not len(better):
            break
        away[ends[better]], before[ends[better]] = found[better], starts[better]
    _flight["before"] = before
    return away
