"""The flow bound on the steps of a team: walks as flows whose steps must newly show the cells.

Its linear program, and how prices of cells and potentials of states come close to its dual, is described in
:mod:`indoor_explorers.env.search.cell_prices`. Prices p and potentials f are made feasible here: no step from a to b
may earn more than 1 + f(b) - f(a), where it earns the prices of the cells that it newly shows. Then a walk earns at
most its length plus f at its end less f at its start, and a team that sees all but k cells earns at least the sum of
all prices without the k largest. So the steps of N UAVs together are at least this sum, plus f at the starts, less N
times the largest f; the longest walk is at least an N-th of that.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.search.cell_prices import CellPrices, cell_prices
from indoor_explorers.env.search.visibility import VisibilityTable, add_visible
from indoor_explorers.env.search.walk_graph import WalkGraph, walk_graph

#: Most rounds of the search for prices, and most effort: rounds times steps and the cells that they show.
ROUNDS, WORK = 600, 50_000_000
#: Fewest rounds for a useful bound, and the rounds from which on states hold the last two cells, which gives a far
#: better bound for twice the work.
FEWEST, TWO_CELLS = 30, 120
#: Factors of the potentials that are tried: smaller ones differ less between neighbours, so that all steps may earn.
PARTS = (1.0, 0.97, 0.9, 0.8)


def flow_bound(table: VisibilityTable, team: int, missable: int) -> int:
    """Return a bound on the steps of a team that may miss ``missable`` of the counted cells.

    The first ``team`` cells of ``table`` are the starts. The bound is 0 on maps too large for it.
    """
    known = np.zeros_like(table.union)
    for start in range(team):
        add_visible(table, start, known)
    graph = walk_graph(table, team, 1, known)
    if missable >= len(graph.unseen) or _rounds(graph) < FEWEST:
        return 0
    if _rounds(graph) >= TWO_CELLS:
        graph = walk_graph(table, team, 2, known)
    found, best = cell_prices(graph, team, missable, _rounds(graph)), 0.0
    for part in PARTS:
        feasible = CellPrices(found.price.copy(), found.potential * part)
        _make_feasible(graph, feasible)
        best = max(best, _worth(feasible, team, missable))
    return math.ceil(best / team - 1e-6)


def _rounds(graph: WalkGraph) -> int:
    return int(min(ROUNDS, WORK // (1 + len(graph.shown) + len(graph.target))))


def _worth(prices: CellPrices, team: int, missable: int) -> float:
    """Return the steps that a team needs together by feasible prices."""
    price: NDArray[np.float64] = np.sort(prices.price)
    potential = prices.potential
    return float(price[: len(price) - missable].sum() + potential[:team].sum() - team * potential.max())


@leaf(entry=False)
def _earned(graph: WalkGraph, step: int, price: np.ndarray) -> float:
    total = 0.0
    for place in range(graph.offsets[step], graph.offsets[step + 1]):
        total += price[graph.shown[place]]
    return total


@leaf(entry=False)
def _lower_potentials(graph: WalkGraph, potential: np.ndarray) -> None:
    """Lower potentials until none is more than one step above that of a state that can be stepped to."""
    states, changed = potential.shape[0], True
    while changed:
        changed = False
        for k in range(2 * states):
            state = k if k < states else 2 * states - 1 - k
            for step in range(graph.first[state], graph.first[state + 1]):
                if potential[state] > potential[graph.target[step]] + 1.0:
                    potential[state], changed = potential[graph.target[step]] + 1.0, True


@kernel()
def _make_feasible(graph: WalkGraph, prices: CellPrices) -> None:
    """Lower potentials and prices so that no step earns more than it may.

    Each price is divided by the largest excess, earned / allowed, of the steps that earn it.
    """
    price, potential = prices
    _lower_potentials(graph, potential)
    excess = np.ones_like(price)
    for state in range(potential.shape[0]):
        for step in range(graph.first[state], graph.first[state + 1]):
            earned = _earned(graph, step, price)
            allowed = 1.0 + potential[graph.target[step]] - potential[state]
            if earned > allowed:
                for place in range(graph.offsets[step], graph.offsets[step + 1]):
                    k = graph.shown[place]
                    excess[k] = max(excess[k], earned / allowed if allowed > 0.0 else np.inf)
    for k in range(price.shape[0]):
        price[k] /= excess[k]
