"""Simulated annealing of a team's routes; the cost of each change is computed by flying the routes with sensing.

S. Kirkpatrick, C. D. Gelatt, M. P. Vecchi, "Optimization by simulated annealing", Science 220, 1983,
doi:10.1126/science.220.4598.671. The changes are those of vehicle routing: remove, insert, shift and exchange stops,
reverse (2-opt) and move (Or-opt) a piece, exchange the tails of two routes.
"""

from __future__ import annotations

import math

import numpy as np

from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.grid.randomness import draw
from indoor_explorers.env.search.visibility import VisibilityTable, count_unseen
from indoor_explorers.planners.reference.routes import (
    Aims,
    DistanceTable,
    Routes,
    TeamState,
    cheapest_place,
    copy,
    cost,
    count_stops,
    cross,
    find_steps,
    put,
    reverse,
    take,
)

#: Cost of each cell that is missing at the end, in steps; so large that no final route misses any.
PENALTY = 10.0
#: Initial temperature as a share of the initial routes' steps, and final temperature in steps.
HOT, COLD = 0.005, 0.25
#: Viewpoints sampled for each stop of the initial routes.
SAMPLES = 100
#: Failed samples per viewpoint after which the initial routes are complete.
MOST_SAMPLES = 64
#: Most stops in a piece that is moved.
PIECE = 8
#: Frequency of each change in percent, as cumulative upper bounds; beyond the last one two routes exchange their tails.
INSERT, SHIFT, RELOCATE, MOVE_PIECE, REMOVE, REVERSE, EXCHANGE = 7, 42, 57, 65, 80, 90, 97


@leaf(entry=False)
def draw_below(rng_state: np.ndarray, sides: int) -> int:
    """Draw an integer from 0 to ``sides`` - 1; ``rng_state`` (2,) uint64 holds a key and a counter."""
    rng_state[1] += np.uint64(1)
    drawn = draw(rng_state[0], rng_state[1]) % np.uint64(sides)
    return int(np.int64(drawn))  # signed, since numba converts mixed integers to floats


@leaf(entry=False)
def _pick(routes: Routes, rng_state: np.ndarray) -> tuple[int, int]:
    """Draw one of all stops, of which there must be one; return its route and position."""
    p = draw_below(rng_state, count_stops(routes))
    n = 0
    while p >= routes.sizes[n]:
        p -= routes.sizes[n]
        n += 1
    return n, p


@leaf(entry=False)
def _insert(table: VisibilityTable, distances: DistanceTable, routes: Routes, state: TeamState, point: int) -> bool:
    find_steps(table, distances, point)
    _, n, p = cheapest_place(distances, routes, state.starts, point)
    return put(routes, n, p, point)


@leaf(entry=False)
def _shift(table: VisibilityTable, distances: DistanceTable, routes: Routes, rng_state: np.ndarray) -> bool:
    """Replace a stop by a viewpoint a few random steps away."""
    n, p = _pick(routes, rng_state)
    cell = distances.points[routes.stops[n, p]]
    for _ in range(1 + draw_below(rng_state, 4)):
        other = table.neighbours[cell, draw_below(rng_state, table.neighbours.shape[1])]
        cell = other if other >= 0 else cell
    point = distances.nearest[cell]
    if point == routes.stops[n, p]:
        return False
    find_steps(table, distances, point)
    routes.stops[n, p] = point
    return True


@leaf(entry=False)
def _relocate(
    table: VisibilityTable, distances: DistanceTable, routes: Routes, state: TeamState, rng_state: np.ndarray
) -> bool:
    """Move a stop to its cheapest position, or to a random one."""
    n, p = _pick(routes, rng_state)
    point = take(routes, n, p)
    if draw_below(rng_state, 2) == 0:
        return _insert(table, distances, routes, state, point)
    m = draw_below(rng_state, routes.sizes.shape[0])
    return put(routes, m, draw_below(rng_state, routes.sizes[m] + 1), point)


@leaf(entry=False)
def _move_piece(routes: Routes, rng_state: np.ndarray) -> bool:
    """Move a few consecutive stops to a random position, reversed in half of the cases."""
    n, p = _pick(routes, rng_state)
    m = draw_below(rng_state, routes.sizes.shape[0])
    size = min(1 + draw_below(rng_state, PIECE), routes.sizes[n] - p)
    turned = draw_below(rng_state, 2) == 0
    if turned:
        reverse(routes, n, p, p + size - 1)
    if m == n:  # two consecutive pieces change places
        left = routes.sizes[n] - p - size
        if left == 0:
            return turned and size > 1
        other = 1 + draw_below(rng_state, left)
        reverse(routes, n, p, p + size - 1)
        reverse(routes, n, p + size, p + size + other - 1)
        reverse(routes, n, p, p + size + other - 1)
        return True
    q = draw_below(rng_state, routes.sizes[m] + 1)
    if not cross(routes, n, p, m, q):
        return False
    return cross(routes, n, p, m, q + size)


@leaf(entry=False)
def _change(
    table: VisibilityTable, distances: DistanceTable, routes: Routes, state: TeamState, rng_state: np.ndarray
) -> bool:
    """Change routes in one random way; return whether they changed."""
    kind = draw_below(rng_state, 100)
    if kind < INSERT or count_stops(routes) == 0:
        return _insert(table, distances, routes, state, draw_below(rng_state, distances.points.shape[0]))
    if kind < SHIFT:
        return _shift(table, distances, routes, rng_state)
    if kind < RELOCATE:
        return _relocate(table, distances, routes, state, rng_state)
    if kind < MOVE_PIECE:
        return _move_piece(routes, rng_state)
    n, p = _pick(routes, rng_state)
    if kind < REMOVE:
        take(routes, n, p)
        return True
    if kind < REVERSE:
        q = draw_below(rng_state, routes.sizes[n])
        reverse(routes, n, min(p, q), max(p, q))
        return p != q
    m, q = _pick(routes, rng_state)
    if kind < EXCHANGE or m == n:
        routes.stops[n, p], routes.stops[m, q] = routes.stops[m, q], routes.stops[n, p]
        return n != m or p != q
    return cross(routes, n, p, m, q)


@leaf(entry=False)
def _construct(
    table: VisibilityTable,
    distances: DistanceTable,
    routes: Routes,
    state: TeamState,
    aims: Aims,
    rng_state: np.ndarray,
) -> None:
    """Insert viewpoints, each the best of some random ones by new cells per step, until the last aim or full routes."""
    samples = SAMPLES
    left = cost(table, distances, routes, state, aims, math.inf)[1]
    while left > 0:
        best, most = -1, 0.0
        for _ in range(samples):
            point = draw_below(rng_state, distances.points.shape[0])
            gain = min(count_unseen(table, distances.points[point], state.seen), left)
            if gain > 0:
                find_steps(table, distances, point)
                score = gain / (cheapest_place(distances, routes, state.starts, point)[0] + 2.0)
                if score > most:
                    best, most = point, score
        if best < 0 and samples > MOST_SAMPLES * distances.points.shape[0]:
            return
        if best < 0:
            samples *= 2
        elif _insert(table, distances, routes, state, best):
            left = cost(table, distances, routes, state, aims, math.inf)[1]
        else:
            return


@kernel()
def anneal(
    table: VisibilityTable,
    distances: DistanceTable,
    state: TeamState,
    aims: Aims,
    key: np.uint64,
    changes: int,
    work: int,
) -> tuple[Routes, float]:
    """Return the best routes found that reach the last aim, and their cost.

    Tries ``changes`` changes; fewer if they take more than ``work`` word operations.
    """
    team, room = state.starts.shape[0], 64 + table.neighbours.shape[0] // 8
    rng_state = np.array([key, np.uint64(0)], np.uint64)
    now = Routes(np.zeros((team, room), np.int32), np.zeros(team, np.int64))
    _construct(table, distances, now, state, aims, rng_state)
    best = Routes(now.stops.copy(), now.sizes.copy())
    tried = Routes(now.stops.copy(), now.sizes.copy())
    least, left = cost(table, distances, now, state, aims, math.inf)
    value = least + PENALTY * left
    hot, begun = max(HOT * value, COLD), state.work[0]
    for change in range(changes):
        spent = max(change / changes, (state.work[0] - begun) / work)
        if spent >= 1.0:
            break
        copy(now, tried)
        if not _change(table, distances, tried, state, rng_state):
            continue
        temperature = hot * (COLD / hot) ** spent
        bar = value - temperature * math.log((draw_below(rng_state, 2**53) + 1) / 2**53)
        steps, left = cost(table, distances, tried, state, aims, bar)
        if steps + PENALTY * left <= bar:
            value = steps + PENALTY * left
            copy(tried, now)
            if left == 0 and steps < least:
                least = steps
                copy(now, best)
    return best, least
