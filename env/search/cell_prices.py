"""Prices of unseen cells: dual values, in steps, of the linear program of all walks.

The program asks for the cheapest flow through a :class:`WalkGraph` from the starts to any ends whose steps newly show
every cell, except for a number that may be missed. Every tour is such a flow, so the least flow is a lower bound on the
steps of a team together. Its dual values are prices of cells and potentials of states: the largest prices for which no
step earns more than 1 plus the rise of the potential.

The solver is deterministic and needs only products with the program's matrix: A. Chambolle and T. Pock, "A first-order
primal-dual algorithm for convex problems with applications to imaging", 2011, doi:10.1007/s10851-010-0251-1, with the
diagonal step sizes of Pock and Chambolle, ICCV 2011, doi:10.1109/ICCV.2011.6126441, and over-relaxation. The dual
values are only nearly feasible: a valid bound must be derived from the earnings that they allow.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.search.walk_graph import WalkGraph

#: Over-relaxation, and primal step sizes relative to dual ones in a few rounds and from ``LONG`` rounds on. Measured in
#: the thesis's rooms and in offices.
RELAXATION, SCALE, LONG_SCALE, LONG = 1.8, 0.3, 0.1, 300
#: Halvings of the interval that the projection onto the missed cells searches.
HALVINGS = 25


class CellPrices(NamedTuple):
    """Dual values, nearly feasible."""

    price: NDArray[np.float64]
    """(K,) price of each unseen cell in steps, not negative."""
    potential: NDArray[np.float64]
    """(S,) potential of each state in steps."""


class _Flow(NamedTuple):
    """Primal values, and scratch for a round's residuals."""

    taken: np.ndarray
    """(A,) how often each step is taken."""
    missed: np.ndarray
    """(K,) how much of each cell is missed."""
    ended: np.ndarray
    """(S,) how many walks end in each state."""
    missing: np.ndarray
    """(K,) what is left to be seen of each cell."""
    excess: np.ndarray
    """(S,) how many more walks enter or start than leave or end."""


@leaf(entry=False)
def _project(missed: np.ndarray, missable: float) -> None:
    """Replace (K,) shares of missed cells by the nearest from 0 to 1 that add up to ``missable`` at most."""
    total, low, high = 0.0, 0.0, 0.0
    for k in range(missed.shape[0]):
        total += min(max(missed[k], 0.0), 1.0)
        high = max(high, missed[k])
    for _ in range(HALVINGS if total > missable else 0):
        middle, total = (low + high) / 2, 0.0
        for k in range(missed.shape[0]):
            total += min(max(missed[k] - middle, 0.0), 1.0)
        low, high = (middle, high) if total > missable else (low, middle)
    less = high if low > 0.0 or total > missable else 0.0
    for k in range(missed.shape[0]):
        missed[k] = min(max(missed[k] - less, 0.0), 1.0)


@leaf(entry=False)
def _move(graph: WalkGraph, prices: CellPrices, flow: _Flow, scale: float) -> None:
    """Make one step of the primal values of walks, and add the effect of their extrapolation to the residuals."""
    for state in range(graph.first.shape[0] - 1):
        for step in range(graph.first[state], graph.first[state + 1]):
            begin, end, target = graph.offsets[step], graph.offsets[step + 1], graph.target[step]
            cost = 1.0 - prices.potential[state] + prices.potential[target]
            for place in range(begin, end):
                cost -= prices.price[graph.shown[place]]
            taken = max(0.0, flow.taken[step] - scale / (end - begin + 2.0) * cost)
            ahead = 2.0 * taken - flow.taken[step]
            flow.taken[step] = max(0.0, flow.taken[step] + RELAXATION * (taken - flow.taken[step]))
            if ahead != 0.0:
                flow.excess[state] -= ahead
                flow.excess[target] += ahead
                for place in range(begin, end):
                    flow.missing[graph.shown[place]] -= ahead


@leaf(entry=False)
def _dual_sizes(graph: WalkGraph, sizes: CellPrices, scale: float) -> None:
    """Fill in the step sizes of prices and of potentials."""
    of_cells, of_states = sizes
    of_cells[:], of_states[:] = 1.0, 1.0
    for place in graph.shown:
        of_cells[place] += 1.0
    for state in range(of_states.shape[0]):
        of_states[state] += graph.first[state + 1] - graph.first[state]
    for target in graph.target:
        of_states[target] += 1.0
    for k in range(of_cells.shape[0]):
        of_cells[k] = 1.0 / (scale * of_cells[k])
    for k in range(of_states.shape[0]):
        of_states[k] = 1.0 / (scale * of_states[k])


@leaf(entry=False)
def _adjust(
    prices: CellPrices, flow: _Flow, trial: np.ndarray, sizes: CellPrices, missable: float, scale: float
) -> None:
    """Make one step of missed cells and ends, then of prices and potentials; ``trial`` (K,) is scratch."""
    price, potential = prices
    for k in range(price.shape[0]):
        trial[k] = flow.missed[k] + scale * price[k]
    _project(trial, missable)
    for k in range(price.shape[0]):
        change = trial[k] - flow.missed[k]
        better = max(0.0, price[k] + sizes.price[k] * (flow.missing[k] - trial[k] - change))
        price[k] = max(0.0, price[k] + RELAXATION * (better - price[k]))
        flow.missed[k] += RELAXATION * change
    for k in range(potential.shape[0]):
        ended = max(0.0, flow.ended[k] + scale * potential[k])
        excess = flow.excess[k] - 2.0 * ended + flow.ended[k]
        flow.ended[k] += RELAXATION * (ended - flow.ended[k])
        potential[k] += RELAXATION * sizes.potential[k] * excess


@kernel()
def cell_prices(graph: WalkGraph, team: int, missable: int, rounds: int) -> CellPrices:
    """Return prices and potentials after ``rounds`` iterations, for ``team`` UAVs that may miss ``missable`` cells."""
    count, states, steps = graph.unseen.shape[0], graph.first.shape[0] - 1, graph.target.shape[0]
    most = 1
    for step in range(steps):
        most = max(most, graph.offsets[step + 1] - graph.offsets[step])
    prices = CellPrices(np.full(count, 1.0 / most), np.zeros(states))
    sizes, trial = CellPrices(np.empty(count), np.empty(states)), np.empty(count)
    scale = LONG_SCALE if rounds >= LONG else SCALE
    _dual_sizes(graph, sizes, scale)
    flow = _Flow(np.zeros(steps), np.zeros(count), np.zeros(states), np.empty(count), np.empty(states))
    for _ in range(rounds):
        flow.missing[:], flow.excess[:], flow.excess[:team] = 1.0, 0.0, 1.0
        _move(graph, prices, flow, scale)
        _adjust(prices, flow, trial, sizes, float(missable), scale)
    return prices
