"""POMCP with macro actions: a search tree over the histories of simulated explorations (Silver & Veness 2010).

Each simulation draws a completion of the map and flies in it with the UAV's own belief: through the tree by upper
confidence bounds, then to nearest frontiers. A macro action flies to one of the frontier clusters of the real belief,
until this is no frontier any more, or to the nearest frontier cell of the simulated one. Its observation is the class
of the number of cells that it has revealed; whole scans would differ in every completion, and no node of the tree would
be visited twice. A return is the sum of the weights of the free cells that become known, discounted by the
steps until then.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import FREE, UNKNOWN
from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.search.frontiers import on_frontier
from indoor_explorers.env.sensing.lidar import LidarModel, Scan, new_scan, visible_cells
from indoor_explorers.planners.toolbox.information.view_gain import AROUND, known_around
from indoor_explorers.planners.toolbox.navigation.paths import search_frontier
from indoor_explorers.planners.toolbox.navigation.shortest_paths import SearchBuffers, path_to, search_to

#: Classes of observations: up to 0, 3, 15, 63 new free cells, and more.
CLASSES = 5


class Problem(NamedTuple):
    """One decision of a UAV."""

    belief: NDArray[np.uint8]
    """(H, W)."""
    start: int
    """The UAV's flat cell."""
    goals: NDArray[np.int32]
    """(K,) flat frontier cells, each within the horizon: the macro actions."""
    maps: NDArray[np.uint8]
    """(P, H, W) completions."""
    owners: NDArray[np.int16]
    """(P, H*W) the cluster whose pocket a cell is of, -1 for none."""
    factors: NDArray[np.float64]
    """Factor on the weights of the cells of each cluster's pocket."""
    weights: NDArray[np.float64]
    """(H*W,) weight of each unknown cell."""
    discount: float
    """Discount of a step."""
    horizon: int
    """Steps that are simulated."""


class Flight(NamedTuple):
    """Working arrays of simulations."""

    belief: np.ndarray
    """(H, W) the simulated belief."""
    buffers: SearchBuffers
    scan: Scan
    searches: np.ndarray
    """(1,) number of the last search."""


class Tree(NamedTuple):
    """Nodes of the search tree, A = K + 1 actions each, the last to the nearest frontier."""

    visits: np.ndarray
    """(N, A)."""
    totals: np.ndarray
    """(N, A) sums of returns."""
    children: np.ndarray
    """(N, A, CLASSES) node after an action and its observation, -1 for none yet."""


@kernel()
def isolation_weights(belief: np.ndarray, isolation: float) -> np.ndarray:
    """Return the weight of each unknown cell, (H*W,): 1 + isolation, if all of its 5x5 is known; 0 of known cells."""
    height, width = belief.shape
    weights = np.zeros(height * width)
    for row in range(height):
        for col in range(width):
            if belief[row, col] == UNKNOWN:
                weights[row * width + col] = 1.0 + isolation * known_around(belief, row, col, 0) / AROUND
    return weights


@leaf()
def observation(found: int) -> int:
    """Return the class of a number of new free cells."""
    kind, most = 0, 0
    while found > most and kind < CLASSES - 1:
        kind, most = kind + 1, 4 * most + 3
    return kind


@kernel(entry=False)
def _fly(
    problem: Problem, flight: Flight, lidar: LidarModel, completion: int, cell: int, step: int, goal: int
) -> tuple[int, int, int, float]:
    """Fly to a flat ``goal``, or to the nearest frontier for -1; return (cell, step, new free cells, return).

    The flight ends when the goal is no frontier any more, or at the horizon. Without a frontier the step is the
    horizon.
    """
    belief, flight_map, owners = flight.belief, problem.maps[completion], problem.owners[completion]
    flat, truth, width = belief.reshape(belief.size), flight_map.reshape(belief.size), belief.shape[1]
    nothing = np.empty(0, np.int32)
    flight.searches[0] += 1
    if goal < 0:
        goal = search_frontier(belief, cell, nothing, np.uint64(0), flight.buffers, flight.searches[0])
        reached = goal >= 0
    else:
        reached = search_to(belief, cell, goal, nothing, flight.buffers, flight.searches[0])
    if not reached:
        return cell, problem.horizon, 0, 0.0
    path, found, total = path_to(flight.buffers.parent, goal), 0, 0.0
    for place in range(1, path.shape[0]):
        if step >= problem.horizon:
            break
        cell, step = path[place], step + 1
        gain = 0.0
        for k in range(visible_cells(flight_map, cell // width, cell % width, lidar, flight.scan)):
            seen = flight.scan.cells[k]
            if flat[seen] == UNKNOWN:
                flat[seen] = truth[seen]
                if truth[seen] == FREE:
                    gain += problem.weights[seen] * problem.factors[owners[seen]]
                    found += 1
        total += problem.discount**step * gain
        if not on_frontier(belief, goal):
            break
    if path.shape[0] == 1:  # on a frontier cell that stays one: nothing more can be seen from here
        step = problem.horizon
    return int(cell), int(step), int(found), float(total)


@kernel(entry=False)
def _by_bound(problem: Problem, belief: np.ndarray, tree: Tree, node: int, scale: float) -> int:
    """Return the action of a node with the largest upper confidence bound (UCB1); -1 for none.

    At the root all goals are tried first. Later nodes try the nearest frontier first, and other actions count as tried
    once with the node's mean return, so that few simulations are not spread over all sequences of goals.
    """
    goals, visits = problem.goals, tree.visits[node]
    nearest, count = goals.shape[0], visits.sum()
    if node > 0 and visits[nearest] == 0:
        return int(nearest)
    best, highest = -1, -np.inf
    mean, log = tree.totals[node].sum() / max(1, count), np.log(count + 1.0)
    for action in range(visits.shape[0]):
        if (action == nearest and node == 0) or (action < nearest and not on_frontier(belief, goals[action])):
            continue
        if visits[action] == 0 and node == 0:
            return int(action)
        value = tree.totals[node, action] / visits[action] if visits[action] > 0 else mean
        bound = value + scale * np.sqrt(log / max(1, visits[action]))
        if bound > highest:
            best, highest = action, bound
    return best


@kernel(entry=False)
def _simulate(
    problem: Problem, flight: Flight, lidar: LidarModel, tree: Tree, nodes: int, scale: float, trace: np.ndarray
) -> tuple[int, float]:
    """Fly one simulation, and add its returns to the tree, which has ``nodes`` nodes; return (nodes, return).

    ``trace`` (D, 2) is scratch for the nodes and actions. The completion is the next one for the first action, so that
    all actions are judged by the same ones.
    """
    flight.belief[:] = problem.belief
    cell, step, node, depth, total = problem.start, 0, 0, 0, 0.0
    before, started = np.zeros(trace.shape[0]), np.zeros(trace.shape[0], np.int64)
    completion = 0
    while depth < trace.shape[0] and step < problem.horizon:
        action = _by_bound(problem, flight.belief, tree, node, scale)
        if action < 0:
            break
        if depth == 0:
            completion = tree.visits[0, action] % problem.maps.shape[0]
        trace[depth, 0], trace[depth, 1], before[depth], started[depth] = node, action, total, step
        depth += 1
        goal = problem.goals[action] if action < problem.goals.shape[0] else -1
        cell, step, found, gain = _fly(problem, flight, lidar, completion, cell, step, goal)
        total += gain
        child = tree.children[node, action, observation(found)]
        if child < 0:
            if nodes < tree.visits.shape[0]:
                tree.children[node, action, observation(found)] = nodes
                nodes += 1
            break
        node = child
    while step < problem.horizon:
        cell, step, found, gain = _fly(problem, flight, lidar, completion, cell, step, -1)
        total += gain
    for k in range(depth):
        tree.visits[trace[k, 0], trace[k, 1]] += 1
        tree.totals[trace[k, 0], trace[k, 1]] += (total - before[k]) / problem.discount ** started[k]
    return nodes, total


@kernel()
def search(
    problem: Problem, lidar: LidarModel, simulations: int, depth: int, exploration: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean returns of the first macro actions, (K,), and how often each was tried, (K,).

    ``depth`` is the most macro actions in the tree; ``exploration`` scales the confidence bounds, in units of the
    difference between the largest and the smallest return so far.
    """
    cells, actions = problem.belief.size, problem.goals.shape[0] + 1
    tree = Tree(
        np.zeros((simulations + 1, actions), np.int64),
        np.zeros((simulations + 1, actions)),
        np.full((simulations + 1, actions, CLASSES), -1, np.int64),
    )
    buffers = SearchBuffers(np.empty(cells, np.int32), np.empty(cells, np.int32), np.zeros(cells, np.int32))
    flight = Flight(problem.belief.copy(), buffers, new_scan(lidar), np.zeros(1, np.int64))
    trace = np.zeros((depth, 2), np.int64)
    nodes, lowest, highest = 1, np.inf, -np.inf
    for _ in range(simulations):
        nodes, total = _simulate(problem, flight, lidar, tree, nodes, exploration * max(highest - lowest, 0.0), trace)
        lowest, highest = min(lowest, total), max(highest, total)
    visits = tree.visits[0, : actions - 1]
    return tree.totals[0, : actions - 1] / np.maximum(visits, 1), visits
