"""A small simulator of teams that move in turn on a lattice, with numpy alone; also a script for a peer's process.

Three rooms in a row of cells of 4 by 4 pixels, 16 pixels between nodes, a lidar of 80 pixels, a radio of 100.
"""

from __future__ import annotations

import os
import sys
from typing import Any

import numpy as np

SIDE, STRIDE, REACH, RADIO = 4, 4, 20, 25
WORLD = np.full((40, 100), 1, np.uint8)
WORLD[0] = WORLD[-1] = WORLD[:, 0] = WORLD[:, -1] = 2
WORLD[:, 35] = WORLD[:, 69] = 2
WORLD[16:25, 35] = WORLD[16:25, 69] = 1
LATTICE = np.argwhere(np.ones((9, 24))) * STRIDE + STRIDE
_flight: dict[str, Any] = {}


def begin(part: str, name: str, team: int, most_nodes: int, seed: int, mended: bool) -> dict[str, Any]:
    """Start an episode."""
    assert part == "hybrid"
    if os.environ.get("FAILS_ON") == name:
        sys.stdout.write("no memory for the map\n")
        sys.stdout.flush()
        os._exit(7)
    beliefs = [np.zeros_like(WORLD) for _ in range(team)]
    places = [LATTICE[k] for k in range(team)]
    _flight.update(beliefs=beliefs, places=places, robot=0, step=0, flown=np.zeros(team), linked=[0], done=False)
    for robot in range(team):
        _scan(robot)
    return _turn()


def move(node: int) -> dict[str, Any]:
    """Move the robot whose turn it is."""
    robot, places, beliefs = _flight["robot"], _flight["places"], _flight["beliefs"]
    assert [_flight["node"], node] in _flight["edges"].tolist()
    target = _flight["nodes"][node]
    _flight["flown"][robot] += SIDE * np.hypot(*(target - places[robot]))
    places[robot] = target
    _scan(robot)
    linked = _flight["linked"] = _component(robot)
    known = np.maximum.reduce([beliefs[k] for k in linked])
    for k in linked:
        beliefs[k][:] = known
    _flight["robot"] = (robot + 1) % len(places)
    if _flight["robot"] == 0:
        _flight["step"] += 1
        _flight["done"] = bool(_explored().min() >= 0.99)
    return _turn()


def _component(robot: int) -> list[int]:
    found, places = [robot], np.array(_flight["places"])
    for one in found:
        near = np.flatnonzero(np.hypot(*(places - places[one]).T) <= RADIO)
        found += [int(k) for k in near if k not in found]
    return sorted(found)


def _explored() -> np.ndarray:
    return np.array([(belief == 1).sum() / (WORLD == 1).sum() for belief in _flight["beliefs"]])


def _clear(belief: np.ndarray, start: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Return which of (K, 2) cells are in sight of one or of (K, 1, 2) others, whatever they are themselves."""
    line = np.rint(start + (ends[:, None] - start) * np.linspace(0, 1, 2 * REACH)[None, :, None]).astype(int)
    inside = (line == ends[:, None]).all(axis=2)
    return np.asarray(((belief[line[..., 0], line[..., 1]] == 1) | inside).all(axis=1))


def _scan(robot: int) -> None:
    at = _flight["places"][robot]
    cells = np.argwhere(np.hypot(*(np.indices(WORLD.shape) - at[:, None, None])) <= REACH)
    seen = cells[_clear(WORLD, at, cells)]
    _flight["beliefs"][robot][tuple(seen.T)] = WORLD[tuple(seen.T)]


def _turn() -> dict[str, Any]:
    robot = _flight["robot"]
    belief, at = _flight["beliefs"][robot], _flight["places"][robot]
    nodes = LATTICE[belief[tuple(LATTICE.T)] == 1]
    one, other = np.nonzero(np.abs(nodes[:, None] - nodes).max(axis=2) <= STRIDE)
    free = _clear(belief, nodes[one][:, None], nodes[other])
    edges = np.stack([one[free], other[free]], axis=1)
    here = int(np.flatnonzero((nodes == at).all(axis=1))[0])
    _flight.update(nodes=nodes, edges=edges, node=here)
    return {
        **{key: _flight[key] for key in ("robot", "step", "done", "linked", "node")},
        "places": _pixels(np.array(_flight["places"])),
        "flown": _flight["flown"].copy(),
        "explored": _explored(),
        "belief": np.kron(belief, np.ones((SIDE, SIDE), np.uint8)),
        "nodes": _pixels(nodes),
        "edges": edges.astype(np.int32),
    }


def _pixels(cells: np.ndarray) -> np.ndarray:
    return np.asarray(SIDE * cells + SIDE // 2, np.int32)
