"""Routes of a team through viewpoints: their cost, and operations that change them.

A route is a list of viewpoints that one UAV visits in turn, on shortest paths from its start; it senses at every step.
All UAVs fly at the same time, and their views are merged.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.search.bfs import flood_table
from indoor_explorers.env.search.visibility import VisibilityTable, add_visible, grown

#: Steps to a cell that cannot be reached.
FAR = np.int32(2**20)


class DistanceTable(NamedTuple):
    """K viewpoints and the steps to them, computed on demand."""

    points: NDArray[np.int32]
    """(K,) number of each viewpoint's cell."""
    nearest: NDArray[np.int32]
    """(M,) the viewpoint nearest to each cell."""
    steps: NDArray[np.int32]
    """(K, M) steps from each cell to each viewpoint."""
    known: NDArray[np.bool_]
    """(K,) whether the steps have been computed."""
    queue: NDArray[np.int32]
    """(M,) scratch."""


class Routes(NamedTuple):
    """The routes of N UAVs."""

    stops: NDArray[np.int32]
    """(N, L) viewpoints in order."""
    sizes: NDArray[np.int64]
    """(N,) number of stops of each route."""


class Aims(NamedTuple):
    """The aims of routes, and the cost of steps."""

    first: int
    """Seen cells at the first aim."""
    last: int
    """Seen cells at the last aim, at least as many."""
    share: float
    """Cost of a step between the first aim and the last; before the first a step costs 1."""


class TeamState(NamedTuple):
    """State of N UAVs while routes are flown."""

    starts: NDArray[np.int64]
    """(N,) numbers of the start cells."""
    cell: NDArray[np.int64]
    """(N,) numbers of the current cells."""
    stop: NDArray[np.int64]
    """(N,) index of the next stop of each route."""
    seen: NDArray[np.uint64]
    """(T,) bit set of the cells seen so far."""
    work: NDArray[np.int64]
    """(1,) word operations so far: the effort of the search, the same on every machine."""


@leaf(entry=False)
def find_steps(table: VisibilityTable, distances: DistanceTable, point: int) -> None:
    """Compute the steps to a viewpoint unless they are known."""
    if distances.known[point]:
        return
    distances.known[point] = True
    steps = distances.steps[point]
    steps[:] = FAR
    steps[distances.points[point]] = 0
    distances.queue[0] = distances.points[point]
    flood_table(table.neighbours, 1, distances.queue, steps)


@leaf(entry=False)
def start(table: VisibilityTable, state: TeamState) -> int:
    """Put the UAVs at their starts; return the number of cells that their first scans show."""
    state.seen[:] = 0
    new = 0
    for n in range(state.starts.shape[0]):
        state.cell[n], state.stop[n] = state.starts[n], 0
        new += add_visible(table, state.starts[n], state.seen)
    return new


@leaf(entry=False)
def fly_on(table: VisibilityTable, distances: DistanceTable, routes: Routes, state: TeamState) -> int:
    """Move every UAV one step along its route; return the number of new cells, -1 when all routes are complete."""
    new = -1
    for n in range(state.cell.shape[0]):
        cell = state.cell[n]
        while state.stop[n] < routes.sizes[n]:
            steps = distances.steps[routes.stops[n, state.stop[n]]]
            if 0 < steps[cell] < FAR:
                break
            state.stop[n] += 1
        if state.stop[n] == routes.sizes[n]:
            continue
        for k in range(table.neighbours.shape[1]):
            other = table.neighbours[cell, k]
            if other >= 0 and steps[other] < steps[cell]:
                state.cell[n] = other
                break
        state.work[0] += table.offsets[other + 1] - table.offsets[other]
        new = max(new, 0) + add_visible(table, state.cell[n], state.seen)
    return new


@leaf(entry=False)
def cost(
    table: VisibilityTable, distances: DistanceTable, routes: Routes, state: TeamState, aims: Aims, limit: float
) -> tuple[float, int]:
    """Fly routes to their ends, the last aim, or a cost above ``limit``; return the cost and the missing cells.

    A step costs 1 before the first aim is reached and ``aims.share`` after it.
    """
    seen, spent = start(table, state), 0.0
    while seen < aims.last and spent <= limit:
        new = fly_on(table, distances, routes, state)
        if new < 0:
            break
        spent += 1.0 if seen < aims.first else aims.share
        seen += new
    return spent, max(aims.last - seen, 0)


@kernel()
def tracks(
    table: VisibilityTable, distances: DistanceTable, routes: Routes, state: TeamState, aims: Aims
) -> np.ndarray:
    """Return the numbers of the UAVs' cells at every step up to the last aim, (steps + 1, N)."""
    team, seen, new, size = state.cell.shape[0], start(table, state), 0, 0
    out = np.empty(1024 * team, np.int64)
    while new >= 0:
        if size == out.shape[0]:
            out = grown(out, 2 * size)
        for n in range(team):
            out[size + n] = state.cell[n]
        size += team
        if seen >= aims.last:
            break
        new = fly_on(table, distances, routes, state)
        seen += new
    return out[:size].reshape((size // team, team))


@leaf(entry=False)
def copy(source: Routes, target: Routes) -> None:
    """Copy routes."""
    for n in range(source.sizes.shape[0]):
        target.sizes[n] = source.sizes[n]
        for p in range(source.sizes[n]):
            target.stops[n, p] = source.stops[n, p]


@leaf(entry=False)
def count_stops(routes: Routes) -> int:
    """Count the stops of all routes."""
    count = 0
    for n in range(routes.sizes.shape[0]):
        count += routes.sizes[n]
    return count


@leaf(entry=False)
def put(routes: Routes, n: int, p: int, point: int) -> bool:
    """Insert a viewpoint as stop ``p`` of route ``n``; return False if the route is full."""
    size = routes.sizes[n]
    if size == routes.stops.shape[1]:
        return False
    for q in range(size, p, -1):
        routes.stops[n, q] = routes.stops[n, q - 1]
    routes.stops[n, p] = point
    routes.sizes[n] += 1
    return True


@leaf(entry=False)
def take(routes: Routes, n: int, p: int) -> int:
    """Remove stop ``p`` from route ``n`` and return it."""
    point = routes.stops[n, p]
    for q in range(p, routes.sizes[n] - 1):
        routes.stops[n, q] = routes.stops[n, q + 1]
    routes.sizes[n] -= 1
    return int(point)


@leaf(entry=False)
def reverse(routes: Routes, n: int, low: int, high: int) -> None:
    """Reverse stops ``low`` to ``high`` of route ``n``."""
    stops = routes.stops[n]
    while low < high:
        stops[low], stops[high] = stops[high], stops[low]
        low, high = low + 1, high - 1


@leaf(entry=False)
def cross(routes: Routes, n: int, p: int, m: int, q: int) -> bool:
    """Exchange the tails of route ``n`` from stop ``p`` on and of route ``m`` from stop ``q`` on."""
    one, other = routes.sizes[n] - p, routes.sizes[m] - q
    if max(p + other, q + one) > routes.stops.shape[1]:
        return False
    for k in range(max(one, other)):
        a, b = (
            routes.stops[n, min(p + k, routes.stops.shape[1] - 1)],
            routes.stops[m, min(q + k, routes.stops.shape[1] - 1)],
        )
        if k < other:
            routes.stops[n, p + k] = b
        if k < one:
            routes.stops[m, q + k] = a
    routes.sizes[n], routes.sizes[m] = p + other, q + one
    return True


@leaf(entry=False)
def cheapest_place(distances: DistanceTable, routes: Routes, starts: np.ndarray, point: int) -> tuple[int, int, int]:
    """Return the cheapest insertion of a viewpoint whose steps are known: the additional steps, the route, the stop."""
    least, best, at = np.int64(FAR) * 4, 0, 0
    for n in range(routes.sizes.shape[0]):
        cell = starts[n]
        for p in range(routes.sizes[n] + 1):
            more = np.int64(distances.steps[point, cell])
            if p < routes.sizes[n]:
                after = distances.steps[routes.stops[n, p]]
                more += np.int64(after[distances.points[point]]) - np.int64(after[cell])
                cell = distances.points[routes.stops[n, p]]
            if more < least:
                least, best, at = more, n, p
    return int(least), best, at
