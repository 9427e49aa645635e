"""Beam search for the shortest tour that leaves at most a given weight of cells unseen.

A state is (cell, set of unseen cells). All states after d steps are ranked, the best are kept, and their
neighbours are the candidates of step d + 1; a state that was reached before, at any step, is dropped.
The rank of a state, lower is better, is

    sum over unseen u of w(u) (1 + isolation (1 - n(u) / 8)) + pull (steps to the next gain) + completion (steps to all)

with w the weight of a cell and n(u) the number of unseen cells among the eight around it. The isolation term makes
scattered leftovers expensive, so that pockets are finished while they are near. Both step counts come
from :mod:`indoor_explorers.planners.toolbox.information.optimistic_views`; the second is a lower bound on the steps
that remain.

The DDDQN's observation has a beam search of its own for rooms of up to 16x16 cells, on boards of four words
(``learners/dddqn/observation/beam.py``): without weights, and many times faster.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from indoor_explorers.env.grid.compiled import inner, kernel
from indoor_explorers.env.search.bitsets import bit_count, holds, intersect, is_new, is_subset

_ONE = np.uint64(1)


class BeamConfig(NamedTuple):
    """Parameters of the search."""

    isolation: float
    """Additional weight of an unseen cell without unseen neighbours."""
    pull: float
    """Weight of a step to the next gain, in cells."""
    completion_weight: float
    """Weight of a step to the unseen cell that takes longest, in cells."""
    width: int
    """Beam width: states kept at each step."""
    depth: int
    """Search depth in steps."""


class SearchGraph(NamedTuple):
    """The graph of the search: C cells, their neighbours, views and weights; sets have W words."""

    views: np.ndarray
    """(C, W) cells visible from a cell."""
    neighbours: np.ndarray
    """(C, 4) neighbours, -1 for none."""
    views_within: np.ndarray
    """(D, C, W) cells that can be seen within d steps from a cell."""
    around: np.ndarray
    """(C, 8) cells around a cell, -1 off the map."""
    keys: np.ndarray
    """(2 C,) hash words of unseen cells, then of the UAV's cell."""
    weights: np.ndarray
    """(C,) weight of seeing a cell."""


class States(NamedTuple):
    """Up to K search states."""

    cell: np.ndarray
    unseen: np.ndarray
    """(K, W)."""
    key: np.ndarray
    """Hash of the unseen set."""
    worth: np.ndarray
    """Sum of the weights of the unseen cells, with isolation."""
    left: np.ndarray
    """Sum of the weights of the unseen cells."""
    delay: np.ndarray
    """Sum of ``left`` over the steps so far: of two tours of equal length the one that sees more early is better."""
    rank: np.ndarray
    node: np.ndarray
    """Index of the state, or of a candidate's parent, in the tree of all kept states."""


class StateTree(NamedTuple):
    """The states kept at all steps."""

    cell: np.ndarray
    parent: np.ndarray


@kernel()
def _new_states(count: int, words: int) -> States:
    return States(
        np.empty(count, np.int32),
        np.empty((count, words), np.uint64),
        np.empty(count, np.uint64),
        np.empty(count),
        np.empty(count),
        np.empty(count),
        np.empty(count),
        np.empty(count, np.int32),
    )


@inner()
def _copy(source: States, s: int, target: States, t: int) -> None:
    target.cell[t], target.key[t] = source.cell[s], source.key[s]
    target.worth[t], target.left[t], target.delay[t] = source.worth[s], source.left[s], source.delay[s]
    target.rank[t], target.node[t] = source.rank[s], source.node[s]
    for w in range(source.unseen.shape[1]):
        target.unseen[t, w] = source.unseen[s, w]


@inner()
def _mark_seen(states: States, s: int, seen: int, graph: SearchGraph, isolation: float) -> None:
    """Subtract one cell, already removed from the unseen set of state ``s``, from its sums."""
    share, near = isolation / 8, 0
    unseen = states.unseen[s]
    for k in range(8):
        cell = graph.around[seen, k]
        if cell >= 0 and holds(unseen, cell):
            near += 1
            states.worth[s] += share * graph.weights[cell]
    states.worth[s] -= graph.weights[seen] * (1 + isolation - share * near)
    states.left[s] -= graph.weights[seen]
    states.key[s] ^= graph.keys[seen]


@inner()
def _move_to(states: States, s: int, cell: int, graph: SearchGraph, isolation: float) -> None:
    """Move state ``s`` to a cell and remove the cells that are seen there."""
    states.cell[s] = cell
    for w in range(states.unseen.shape[1]):
        new = states.unseen[s, w] & graph.views[cell, w]
        while new != 0:
            lowest = new & (~new + _ONE)
            new ^= lowest
            states.unseen[s, w] ^= lowest
            _mark_seen(states, s, w * 64 + int(np.int64(bit_count(lowest - _ONE))), graph, isolation)
    states.delay[s] += states.left[s]


@inner()
def _rank(states: States, s: int, graph: SearchGraph, config: BeamConfig) -> None:
    """Compute the rank of state ``s``; lower is better."""
    cell, unseen, farthest = states.cell[s], states.unseen[s], graph.views_within.shape[0]
    first = 0
    while first < farthest and not intersect(unseen, graph.views_within[first, cell]):
        first += 1
    last = first
    while config.completion_weight > 0 and last < farthest and not is_subset(unseen, graph.views_within[last, cell]):
        last += 1
    states.rank[s] = states.worth[s] + config.pull * first + config.completion_weight * last


@kernel()
def _root(start: int, unseen: np.ndarray, graph: SearchGraph, isolation: float, states: States) -> None:
    """Write the initial state 0 from the UAV's cell and the unseen set."""
    share = isolation / 8
    states.cell[0], states.key[0], states.node[0] = start, np.uint64(0), 0
    states.worth[0], states.left[0], states.delay[0], states.rank[0] = 0.0, 0.0, 0.0, 0.0
    states.unseen[0] = unseen
    for cell in range(graph.views.shape[0]):
        if holds(unseen, cell):
            near = 0
            for k in range(8):
                near += graph.around[cell, k] >= 0 and holds(unseen, graph.around[cell, k])
            states.key[0] ^= graph.keys[cell]
            states.left[0] += graph.weights[cell]
            states.worth[0] += graph.weights[cell] * (1 + isolation - share * near)


@kernel()
def _expand(
    states: States, count: int, graph: SearchGraph, config: BeamConfig, rest: float, table: np.ndarray, children: States
) -> tuple[int, int]:
    """Write the new successors of all states to ``children``; return their number and the best finished one, or -1."""
    found, done = 0, -1
    for s in range(count):
        for k in range(4):
            cell = graph.neighbours[states.cell[s], k]
            if cell < 0:
                continue
            _copy(states, s, children, found)
            _move_to(children, found, cell, graph, config.isolation)
            if not is_new(table, children.key[found] ^ graph.keys[graph.views.shape[0] + cell]):
                continue
            _rank(children, found, graph, config)
            if children.left[found] <= rest and (done < 0 or children.delay[found] < children.delay[done]):
                done = found
            found += 1
    return found, done


@kernel(entry=False)
def _select(rank: np.ndarray, order: np.ndarray, keep: int) -> None:
    """Bring the ``keep`` smallest of ``rank[order]`` to the front of ``order`` (Hoare's quickselect)."""
    low, high = 0, order.shape[0] - 1
    while low < high:
        pivot, i, j = rank[order[(low + high) // 2]], low, high
        while i <= j:
            while rank[order[i]] < pivot:
                i += 1
            while rank[order[j]] > pivot:
                j -= 1
            if i <= j:
                order[i], order[j] = order[j], order[i]
                i, j = i + 1, j - 1
        if keep - 1 <= j:
            high = j
        elif keep - 1 >= i:
            low = i
        else:
            return


@kernel(entry=False)
def _keep(children: States, found: int, config: BeamConfig, states: States, tree: StateTree, nodes: int) -> int:
    """Move the best children to ``states`` and into the tree; return their number."""
    order = np.arange(found)
    kept = min(found, config.width)
    if kept < found:
        _select(children.rank, order, kept)
    for s in range(kept):
        _copy(children, order[s], states, s)
        tree.cell[nodes + s], tree.parent[nodes + s] = states.cell[s], states.node[s]
        states.node[s] = nodes + s
    return kept


@kernel(entry=False)
def _traced(tree: StateTree, node: int, last: int) -> np.ndarray:
    """Return the cells after the root up to ``node``, then ``last`` if that is a cell."""
    cells = [np.int32(last)]
    while node > 0:
        cells.append(tree.cell[node])
        node = tree.parent[node]
    tour = np.array(cells[::-1], np.int32)
    return tour if last >= 0 else tour[:-1]


@kernel()
def shortest_tour(
    start: int, unseen: np.ndarray, graph: SearchGraph, rest: float, config: BeamConfig
) -> tuple[np.ndarray, bool]:
    """Return the cells of the shortest tour found, without the start, and whether it is finished.

    A finished tour leaves cells of a total weight of at most ``rest`` unseen. Otherwise the tour leads to the best
    state that is ``config.depth`` steps away.
    """
    words = graph.views.shape[1]
    states, children = _new_states(config.width, words), _new_states(4 * config.width, words)
    tree = StateTree(
        np.empty(config.width * config.depth + 1, np.int32), np.empty(config.width * config.depth + 1, np.int32)
    )
    size = 64
    while size < 4 * config.width * config.depth:
        size *= 2
    table = np.zeros(size, np.uint64)
    _root(start, unseen, graph, config.isolation, states)
    count, nodes = 1, 1
    for _ in range(config.depth):
        found, done = _expand(states, count, graph, config, rest, table, children)
        if done >= 0:
            return _traced(tree, children.node[done], children.cell[done]), True
        if found == 0:
            break
        count = _keep(children, found, config, states, tree, nodes)
        nodes += count
    best = np.argmin(states.rank[:count])
    return _traced(tree, states.node[best], -1), False
