"""Open tours: short orders of visits to K places, with a fixed first place and a free end.

Costs are a (K, K) matrix of finite numbers, ``costs[a, b]`` the cost of going from a to b, symmetric or not. An order
is (K,) int64, the first place first. Nearest neighbour makes an initial order, 2-opt (Croes 1958,
doi:10.1287/opre.6.6.791) and Or-opt (Or 1976) improve it until neither finds an improvement, and new places are
inserted where they cost least (Rosenkrantz, Stearns & Lewis 1977, doi:10.1137/0206041). All of it is deterministic.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.compiled import kernel

#: (K, K) numbers, the cost of going from the first index to the second.
Costs = NDArray[Any]
#: (K,) places in the order in which they are visited.
Order = NDArray[np.int64]

#: Largest number of places that Or-opt moves at once.
LONGEST_PIECE = 3
#: Saving that a change must exceed, because of rounding.
ROUNDING = 1e-9


@kernel()
def _length(costs: np.ndarray, order: np.ndarray) -> float:
    total = 0.0
    for k in range(1, order.shape[0]):
        total += costs[order[k - 1], order[k]]
    return total


@kernel()
def _nearest_neighbour(costs: np.ndarray, first: int) -> np.ndarray:
    count = costs.shape[0]
    order, left = np.empty(count, np.int64), np.ones(count, np.bool_)
    place = first
    for k in range(count):
        order[k], left[place] = place, False
        best = -1
        for other in range(count):
            if left[other] and (best < 0 or costs[place, other] < costs[place, best]):
                best = other
        place = best
    return order


@kernel(entry=False)
def _two_opt(costs: np.ndarray, order: np.ndarray) -> bool:
    """Reverse pieces of ``order`` whose reversal shortens it; return whether there was one."""
    count, found = order.shape[0], False
    for i in range(1, count - 1):
        before, forth, back = order[i - 1], 0.0, 0.0
        for j in range(i + 1, count):
            forth += costs[order[j - 1], order[j]]
            back += costs[order[j], order[j - 1]]
            old, new = costs[before, order[i]] + forth, costs[before, order[j]] + back
            if j + 1 < count:
                old += costs[order[j], order[j + 1]]
                new += costs[order[i], order[j + 1]]
            if new < old - ROUNDING:
                order[i : j + 1] = order[i : j + 1][::-1].copy()
                found = True
                break
    return found


@kernel(entry=False)
def _joined(costs: np.ndarray, before: int, head: int, tail: int, after: int) -> float:
    """Return the cost of the edges into and out of a piece; -1 for ``after`` is the free end."""
    return float(costs[before, head] + (costs[tail, after] if after >= 0 else 0.0))


@kernel(entry=False)
def _moved(order: np.ndarray, i: int, size: int, at: int, turned: bool) -> None:
    """Move ``order[i : i + size]`` to where it follows the place at ``at``, reversed when ``turned``."""
    piece = order[i : i + size].copy()
    if turned:
        piece = piece[::-1].copy()
    if at < i:
        order[at + 1 + size : i + size] = order[at + 1 : i].copy()
        order[at + 1 : at + 1 + size] = piece
    else:
        order[i : at + 1 - size] = order[i + size : at + 1].copy()
        order[at + 1 - size : at + 1] = piece


@kernel(entry=False)
def _or_opt(costs: np.ndarray, order: np.ndarray) -> bool:
    """Move short pieces of ``order`` to cheaper positions; return whether there was one."""
    count, found = order.shape[0], False
    for size in range(1, min(LONGEST_PIECE, count - 2) + 1):
        for i in range(1, count - size + 1):
            head, tail = order[i], order[i + size - 1]
            after = order[i + size] if i + size < count else -1
            saved = _joined(costs, order[i - 1], head, tail, after)
            saved -= costs[order[i - 1], after] if after >= 0 else 0.0
            turning = _length(costs, order[i : i + size][::-1]) - _length(costs, order[i : i + size])
            for at in range(count):
                if i - 1 <= at < i + size:
                    continue
                follower = order[at + 1] if at + 1 < count else -1
                gap = costs[order[at], follower] if follower >= 0 else 0.0
                straight = _joined(costs, order[at], head, tail, follower) - gap
                turned = _joined(costs, order[at], tail, head, follower) - gap + turning
                if min(straight, turned) < saved - ROUNDING:
                    _moved(order, i, size, at, turned < straight)
                    found = True
                    break
    return found


@kernel()
def _improve(costs: np.ndarray, order: np.ndarray) -> None:
    while _two_opt(costs, order) or _or_opt(costs, order):
        pass


@kernel(entry=False)
def _cheapest(costs: np.ndarray, order: np.ndarray, place: int) -> tuple[int, float]:
    """Return the index of ``order`` after which inserting a place costs least, and this cost."""
    where, least = 0, np.inf
    for at in range(order.shape[0]):
        follower = order[at + 1] if at + 1 < order.shape[0] else -1
        extra = _joined(costs, order[at], place, place, follower)
        extra -= costs[order[at], follower] if follower >= 0 else 0.0
        if extra < least:
            where, least = at, extra
    return where, least


@kernel()
def _share_out(costs: np.ndarray, starts: int) -> np.ndarray:
    count = costs.shape[0] - starts
    owner, left = np.full(count, -1, np.int64), np.ones(count, np.bool_)
    tours, sizes = np.zeros((starts, count + 1), np.int64), np.ones(starts, np.int64)
    tours[:, 0] = np.arange(starts)
    lengths = np.zeros(starts)
    for _ in range(count):
        least, place, who, where = np.inf, 0, 0, 0
        for k in range(count):
            for i in range(starts if left[k] else 0):
                at, extra = _cheapest(costs, tours[i, : sizes[i]], starts + k)
                if lengths[i] + extra < least:
                    least, place, who, where = lengths[i] + extra, k, i, at
        owner[place], left[place] = who, False
        tours[who, where + 2 : sizes[who] + 1] = tours[who, where + 1 : sizes[who]].copy()
        tours[who, where + 1] = starts + place
        sizes[who] += 1
        lengths[who] = least
    return owner


def _float(costs: Costs) -> NDArray[np.float64]:
    return np.ascontiguousarray(costs, np.float64)


def nearest_neighbour(costs: Costs, first: int = 0) -> Order:
    """Return the nearest-neighbour order: the nearest unvisited place comes next, the first among equals."""
    return np.asarray(_nearest_neighbour(_float(costs), first))


def improved(costs: Costs, order: Order) -> Order:
    """Return ``order`` improved until neither 2-opt nor Or-opt can shorten it; its first place stays."""
    better = np.array(order, np.int64)
    _improve(_float(costs), better)
    return better


def open_tour(costs: Costs, first: int = 0) -> Order:
    """Return a short order of all K places that begins with ``first``: nearest neighbour, then improved."""
    costs = _float(costs)
    return improved(costs, nearest_neighbour(costs, first))


def shared_out(costs: Costs, starts: int) -> Order:
    """Return the tour that each of K places belongs to, (K,); the first ``starts`` rows are the starts of the tours.

    An auction assigns one place at a time: the pair of place and tour that gives the shortest tour including the place
    (M. G. Lagoudakis et al., "Auction-based multi-robot routing", RSS 2005, doi:10.15607/RSS.2005.I.045).
    """
    return np.asarray(_share_out(_float(costs), starts))
