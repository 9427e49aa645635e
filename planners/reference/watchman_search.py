"""Depth-first search for walks that show enough cells within a number of steps, or the proof that there are none.

The UAVs move in turn, each once a step. A state is left as soon as the prices of the unseen cells, except the most
valuable ones that may be missed, add up to more than the UAVs can earn in their remaining steps; see
:mod:`indoor_explorers.env.search.cell_prices`. Prices are integers, so that no rounding enters the proof.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.search.bitsets import lowest
from indoor_explorers.env.search.walk_graph import WalkGraph

#: Outcomes of a search.
NONE, FOUND, UNDECIDED = 0, 1, 2
_ONE = np.uint64(1)


class Prices(NamedTuple):
    """K cells that must be seen, the highest price first, and what UAVs can earn by seeing them."""

    price: NDArray[np.int64]
    """(64 W,) their prices, 0 where there is no cell; W words hold a set of them."""
    views: NDArray[np.uint64]
    """(M, W) the cells in view from each cell of the map."""
    earned: NDArray[np.int64]
    """(T + 1, S) the most that a UAV in each state can earn in 0 to T steps, forgotten cells counted again."""
    cells: int
    """K."""
    missable: int
    """How many of them may be missed."""


class Branches(NamedTuple):
    """The states on the way from the root, by the number of moves D of all UAVs."""

    seen: NDArray[np.uint64]
    """(D + 1, W) seen cells."""
    place: NDArray[np.int64]
    """(D + 1, N) state of each UAV in the walk graph."""
    unseen: NDArray[np.int64]
    """(D + 1,) number of unseen cells."""
    worth: NDArray[np.int64]
    """(D + 1,) sum of their prices."""
    choice: NDArray[np.int64]
    """(D + 1, 4) states that the next UAV may move to, the most promising last."""
    spare: NDArray[np.int64]
    """(D + 1, 4) most prices that can be earned in the moves left after each of them, less the prices missing."""
    left: NDArray[np.int64]
    """(D + 1,) how many of them have not been tried."""


class Visited(NamedTuple):
    """A hash table of states that were searched; a newer one takes the place of an older one."""

    key: NDArray[np.uint64]
    """(P, W + N) seen cells, then the UAVs' states with whose turn it is; P is a power of two."""
    moves: NDArray[np.int64]
    """(P,) moves that were left, 0 for none: nothing is found within these."""
    order: NDArray[np.uint64]
    """(N,) scratch."""


def new_visited(size: int, words: int, team: int) -> Visited:
    """Return an empty table."""
    key, moves = np.zeros((size, words + team), np.uint64), np.zeros(size, np.int64)
    return Visited(key, moves, np.zeros(team, np.uint64))


def new_branches(moves: int, team: int, words: int) -> Branches:
    """Return room for ``moves`` moves of all UAVs."""
    size = moves + 1
    seen, place = np.zeros((size, words), np.uint64), np.zeros((size, team), np.int64)
    unseen, worth, left = (np.zeros(size, np.int64) for _ in range(3))
    choice, spare = (np.zeros((size, 4), np.int64) for _ in range(2))
    return Branches(seen, place, unseen, worth, choice, spare, left)


@kernel()
def most_earned(graph: WalkGraph, price: np.ndarray, steps: int) -> np.ndarray:
    """Return the most that can be earned from each state in 0, 1, ... ``steps`` steps, (steps + 1, S) int64.

    ``price`` (K,) int64 are the prices of the graph's unseen cells.
    """
    most = np.zeros((steps + 1, graph.cells.shape[0]), np.int64)
    earns = np.zeros(graph.target.shape[0], np.int64)
    for step in range(earns.shape[0]):
        for place in range(graph.offsets[step], graph.offsets[step + 1]):
            earns[step] += price[graph.shown[place]]
    for k in range(1, steps + 1):
        for state in range(graph.cells.shape[0]):
            best = most[k - 1, state]
            for step in range(graph.first[state], graph.first[state + 1]):
                best = max(best, earns[step] + most[k - 1, graph.target[step]])
            most[k, state] = best
    return most


@leaf(entry=False)
def _look(prices: Prices, cell: int, seen: np.ndarray, after: np.ndarray) -> tuple[int, int]:
    """Write ``seen`` (W,) with the view from a cell to ``after`` (W,); return the number and worth of the new cells."""
    count, worth = 0, np.int64(0)
    for w in range(seen.shape[0]):
        new = prices.views[cell, w] & ~seen[w]
        after[w] = seen[w] | new
        while new != 0:
            worth += prices.price[64 * w + lowest(new)]
            count += 1
            new &= new - _ONE
    return count, int(worth)


@leaf(entry=False)
def _most_valuable_unseen(prices: Prices, seen: np.ndarray) -> int:
    """Return the worth of the most valuable unseen cells that may be missed."""
    worth, left = np.int64(0), prices.missable
    for w in range(seen.shape[0]):
        missing = ~seen[w]
        while missing != 0 and left > 0:
            worth += prices.price[64 * w + lowest(missing)]
            missing &= missing - _ONE
            left -= 1
    return int(worth)


@leaf(entry=False)
def _in_order(place: np.ndarray, turn: int, order: np.ndarray) -> None:
    """Write the states of the UAVs to ``order`` (N,), sorted where a step begins, as UAVs are alike."""
    for n in range(place.shape[0]):
        number, k = np.uint64(place[n] * place.shape[0] + turn), n
        while turn == 0 and k > 0 and order[k - 1] > number:
            order[k] = order[k - 1]
            k -= 1
        order[k] = number


@leaf(entry=False)
def _is_new(visited: Visited, seen: np.ndarray, place: np.ndarray, turn: int, moves: int) -> bool:
    """Tell whether a state was not searched with as many moves left, and remember it."""
    _in_order(place, turn, visited.order)
    hashed, words = np.uint64(0), seen.shape[0]
    for w in range(visited.key.shape[1]):
        hashed = (hashed ^ (hashed >> np.uint64(29))) + (seen[w] if w < words else visited.order[w - words])
        hashed *= np.uint64(0xBF58476D1CE4E5B9)
    slot = (hashed ^ (hashed >> np.uint64(32))) & np.uint64(visited.key.shape[0] - 1)
    key = visited.key[slot]
    same = visited.moves[slot] >= moves
    for w in range(key.shape[0]):
        same = same and key[w] == (seen[w] if w < words else visited.order[w - words])
    if same:
        return False
    for w in range(key.shape[0]):
        key[w] = seen[w] if w < words else visited.order[w - words]
    visited.moves[slot] = moves
    return True


@leaf(entry=False)
def _insert(tree: Branches, depth: int, state: int, slack: int) -> None:
    """Insert a state into the choices, which are in order of their slack."""
    choice, spare, k = tree.choice[depth], tree.spare[depth], tree.left[depth]
    while k > 0 and spare[k - 1] > slack:
        choice[k], spare[k] = choice[k - 1], spare[k - 1]
        k -= 1
    choice[k], spare[k] = state, slack
    tree.left[depth] += 1


@leaf(entry=False)
def _branch(graph: WalkGraph, prices: Prices, tree: Branches, depth: int, moves: int) -> None:
    """List the moves of the next UAV after which enough can still be earned in the rest of ``moves``."""
    place, team = tree.place[depth], tree.place.shape[1]
    turn, steps = depth % team, moves // team - depth // team
    others = np.int64(0)
    for n in range(team):
        if n != turn:
            others += prices.earned[steps - 1 if n < turn else steps, place[n]]
    tree.left[depth] = 0
    for step in range(graph.first[place[turn]], graph.first[place[turn] + 1]):
        state, after = graph.target[step], tree.seen[depth + 1]
        _, worth = _look(prices, graph.cells[state, 0], tree.seen[depth], after)
        missing = tree.worth[depth] - worth - _most_valuable_unseen(prices, after)
        slack = prices.earned[steps - 1, state] + others - missing
        if slack >= 0:
            _insert(tree, depth, state, slack)


@leaf(entry=False)
def _enter(graph: WalkGraph, prices: Prices, tree: Branches, depth: int) -> None:
    """Move the next UAV to the most promising state that was not tried, one level down."""
    turn = depth % tree.place.shape[1]
    tree.left[depth] -= 1
    for n in range(tree.place.shape[1]):
        tree.place[depth + 1, n] = tree.place[depth, n]
    state = tree.choice[depth, tree.left[depth]]
    tree.place[depth + 1, turn] = state
    count, worth = _look(prices, graph.cells[state, 0], tree.seen[depth], tree.seen[depth + 1])
    tree.unseen[depth + 1], tree.worth[depth + 1] = tree.unseen[depth] - count, tree.worth[depth] - worth


@leaf()
def search(
    graph: WalkGraph, prices: Prices, tree: Branches, visited: Visited, moves: int, most: int
) -> tuple[int, int, int]:
    """Search from the root, the first row of ``tree``, for enough seen cells within ``moves`` of all UAVs together.

    Returns:
        The outcome; the depth where enough is seen, up to which the rows of ``tree`` are the walks; and the number of
        expanded states, at most ``most``, after which the search is undecided.

    """
    team, depth, expanded, fresh = tree.place.shape[1], 0, 0, True
    while depth >= 0:
        if fresh:
            if tree.unseen[depth] <= prices.missable:
                return FOUND, depth, expanded
            if expanded >= most:
                return UNDECIDED, depth, expanded
            expanded += 1
            tree.left[depth] = 0
            left = moves - depth
            if left > 0 and _is_new(visited, tree.seen[depth], tree.place[depth], depth % team, left):
                _branch(graph, prices, tree, depth, moves)
        fresh = tree.left[depth] > 0
        if fresh:
            _enter(graph, prices, tree, depth)
        depth += 1 if fresh else -1
    return NONE, 0, expanded
