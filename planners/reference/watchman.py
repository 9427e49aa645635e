"""The fewest steps in which UAVs that know the map can see enough of it: the watchman route problem, solved exactly.

On grids it was solved by A* with heuristics from places that must be looked at (Seiref, Jaffey, Lopatin and Felner,
"Solving the Watchman Route Problem on a Grid with Heuristic Search", ICAPS 2020, doi:10.1609/icaps.v30i1.6668; Skyler,
Atzmon, Yaffe and Felner, JAIR 75, 2022, doi:10.1613/jair.1.13685; for several UAVs and the longest path, Gouru, Felner
and Li, arXiv:2604.15610). With a lidar of a few cells nearly every cell must be looked for, and the bound comes from a
linear program instead: the prices of cells for which no walk earns more than its steps
(:mod:`indoor_explorers.env.search.cell_prices`). Numbers of steps are tried from the bound upwards, each by a
depth-first search that leaves a state as soon as too little can be earned
(:mod:`indoor_explorers.planners.reference.watchman_search`).

UAVs may share a cell here and pass through each other, which can only be quicker: the proved number is a lower bound
for every team, and flights may take longer where two UAVs meet.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.search.cell_prices import cell_prices
from indoor_explorers.env.search.visibility import VisibilityTable, add_visible, count_cells
from indoor_explorers.env.search.walk_graph import WalkGraph, walk_graph
from indoor_explorers.planners.reference.watchman_search import (
    FOUND,
    NONE,
    Branches,
    Prices,
    Visited,
    most_earned,
    new_branches,
    new_visited,
    search,
)

#: Rounds of the method that finds prices: more are quicker for two UAVs and slower for one.
ROUNDS = 4000
#: Price of a step: prices of cells are whole numbers of these parts.
PARTS = 2**20
#: Remembered cells of the walk graph that is tried first, and that of the hard rooms, whose prices take longer.
MEMORY, LONG_MEMORY = 2, 3
#: Expanded states after which a room counts as hard.
EASY = 200_000
#: States that the search remembers.
REMEMBERED = 2**20


class Watch(NamedTuple):
    """A task: see enough cells."""

    table: VisibilityTable
    """The views from the map's cells; the first ``team`` cells are the starts."""
    team: int
    known: NDArray[np.uint64]
    """(T,) cells seen before, without the views from the starts."""
    needed: int
    """Number of cells that must be seen in the end, including those seen before."""


class Solution(NamedTuple):
    """Bounds on the fewest steps, and walks."""

    lower: int
    """No team can do it in fewer."""
    walks: tuple[tuple[int, ...], ...] | None
    """The cells of each UAV at each step, in ``lower`` steps; None if none were found."""
    expanded: int
    """States that were expanded."""


class _Stage(NamedTuple):
    """A walk graph with its prices."""

    graph: WalkGraph
    prices: Prices


def fewest_steps(watch: Watch, below: int, most: int) -> Solution:
    """Return the fewest steps, if they are fewer than ``below``, within ``most`` expanded states.

    ``below`` is a number of steps that is known to suffice; if none fewer do, ``lower`` becomes ``below``.
    """
    lower, expanded = 0, 0
    for memory, limit in ((MEMORY, min(EASY, most)), (LONG_MEMORY, most)):
        stage = _stage(watch, memory, below)
        visited = new_visited(REMEMBERED, stage.prices.views.shape[1], watch.team)
        lower, outcome = max(lower, _earliest(stage, watch, below)), NONE
        while lower < below and outcome == NONE:
            outcome, walks, spent = _walks(stage, watch, visited, lower, limit - expanded)
            expanded += spent
            if outcome == FOUND:
                return Solution(lower, walks, expanded)
            lower += outcome == NONE
        if lower >= below:
            break
    return Solution(lower, None, expanded)


def _walks(
    stage: _Stage, watch: Watch, visited: Visited, steps: int, most: int
) -> tuple[int, tuple[tuple[int, ...], ...] | None, int]:
    """Search for walks of a number of steps; return the outcome, the walks if any, and the number of expanded states.

    The last UAVs may have one step less.
    """
    tree, team = _root(stage, watch, steps), watch.team
    outcome, depth, spent = search(stage.graph, stage.prices, tree, visited, steps * team, most)
    if outcome != FOUND:
        return outcome, None, spent
    cells = stage.graph.cells[tree.place[: depth + 1], 0]
    return outcome, tuple(tuple(cells[[0, *range(n + 1, depth + 1, team)], n].tolist()) for n in range(team)), spent


def _stage(watch: Watch, memory: int, steps: int) -> _Stage:
    known = watch.known.copy()
    for start in range(watch.team):
        add_visible(watch.table, start, known)
    graph = walk_graph(watch.table, watch.team, memory, known)
    countable = count_cells(known | watch.table.union)
    prices, _ = cell_prices(graph, watch.team, countable - watch.needed, ROUNDS)
    whole, count = np.floor(prices * PARTS).astype(np.int64), len(prices)
    order = np.argsort(-whole, kind="stable")
    words = max(1, math.ceil(count / 64))
    price = np.zeros(64 * words, np.int64)
    price[:count] = whole[order]
    earned = most_earned(graph, whole, steps)
    views = _views(watch.table, graph.unseen[order], words)
    return _Stage(graph, Prices(price, views, earned, count, countable - watch.needed))


def _views(table: VisibilityTable, cells: NDArray[np.int32], words: int) -> NDArray[np.uint64]:
    """Return which of some cells are in view from each cell of the map, (M, W)."""
    bit = np.full(64 * len(table.union), -1)
    bit[cells] = np.arange(len(cells))
    seen = np.unpackbits(table.bits.view(np.uint8), bitorder="little").reshape(-1, 64).astype(bool)
    place, shift = np.nonzero(seen)
    number = bit[64 * table.tile[place] + shift]
    views = np.zeros((len(table.cells), 64 * words), np.bool_)
    views[np.repeat(np.arange(len(table.cells)), np.diff(table.offsets))[place[number >= 0]], number[number >= 0]] = (
        True
    )
    return np.packbits(views, axis=1, bitorder="little").view(np.uint64)


def _root(stage: _Stage, watch: Watch, steps: int) -> Branches:
    tree = new_branches(steps * watch.team, watch.team, stage.prices.views.shape[1])
    tree.place[0] = np.arange(watch.team)
    tree.unseen[0], tree.worth[0] = stage.prices.cells, stage.prices.price.sum()
    return tree


def _earliest(stage: _Stage, watch: Watch, below: int) -> int:
    """Return the fewest steps in which enough can be earned, at most ``below``."""
    prices = stage.prices
    missing = prices.price.sum() - prices.price[: prices.missable].sum()
    enough = prices.earned[:, : watch.team].sum(axis=1) >= missing
    enough &= prices.cells <= prices.missable or np.arange(len(enough)) > 0
    return int(np.argmax(enough)) if enough.any() else below


def steps_to(table: VisibilityTable, walks: Sequence[Sequence[int]], needed: int) -> int | None:
    """Return the first step at which walks (numbers of cells) have shown ``needed`` cells; None if they do not."""
    seen, count = np.zeros_like(table.union), 0
    for step in range(max(map(len, walks))):
        count += sum(add_visible(table, walk[step], seen) for walk in walks if step < len(walk))
        if count >= needed:
            return step
    return None
