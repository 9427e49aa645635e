"""The probability of obstacles in a room whose generator is known: Gibbs sampling of the places of its rectangles.

Each Markov chain holds a place for every rectangle. In turn, each rectangle is removed and put back at a place drawn
with its probability given the others and the belief: a place that covers a cell known to be free is almost impossible,
and so is leaving a known obstacle uncovered (S. Geman and D. Geman 1984, doi:10.1109/TPAMI.1984.4767596). Chains are
continued from step to step, as one scan changes little.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.grid.compiled import inner, kernel
from indoor_explorers.env.grid.randomness import draw
from indoor_explorers.env.maps.generators.thesis import ThesisMaps

#: Factor on a room's probability for each cell that contradicts the belief.
CONTRADICTION = 1e-3


@inner()
def _put(covers: np.ndarray, cells: np.ndarray, change: int) -> None:
    """Add ``change`` to the cover count of a rectangle's cells."""
    for k in range(cells.shape[0]):
        if cells[k] >= 0:
            covers[cells[k]] += change


@kernel(entry=False)
def _drawn(weights: np.ndarray, bits: np.uint64) -> int:
    """Return an index drawn in proportion to weights."""
    left = np.float64(bits >> np.uint64(11)) / 2.0**53 * weights.sum()
    for k in range(weights.shape[0] - 1):
        left -= weights[k]
        if left < 0:
            return k
    return int(weights.shape[0] - 1)


@kernel(entry=False)
def _fits(belief: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the weight of each place (P,) by the known free cells that it covers."""
    fits = np.ones(places.shape[0])
    for p in range(places.shape[0]):
        for cell in places[p]:
            if cell >= 0 and belief[cell] == FREE:
                fits[p] *= CONTRADICTION
    return fits


@kernel()
def _sweep(
    belief: np.ndarray, places: np.ndarray, covering: np.ndarray, chains: np.ndarray, covers: np.ndarray, key: np.uint64
) -> None:
    """Draw a new place for every rectangle in all chains (K, M); ``covers`` (K, C) counts the rectangles on a cell."""
    fits = _fits(belief, places)
    obstacles = np.flatnonzero(belief == OCCUPIED)
    counter = np.uint64(0)
    for k in range(chains.shape[0]):
        for m in range(chains.shape[1]):
            _put(covers[k], places[chains[k, m]], -1)
            weights = fits.copy()
            for cell in obstacles:
                if covers[k, cell] == 0:
                    for place in covering[cell]:
                        if place >= 0:
                            weights[place] /= CONTRADICTION
            chains[k, m] = _drawn(weights, draw(key, counter))
            counter += np.uint64(1)
            _put(covers[k], places[chains[k, m]], 1)


@kernel()
def _agreeing(belief: np.ndarray, covers: np.ndarray) -> np.ndarray:
    """Return the chains whose room agrees with a flat belief."""
    agree = np.empty(covers.shape[0], np.bool_)
    for k in range(covers.shape[0]):
        free = covers[k] == 0
        agree[k] = not np.any((free & (belief == OCCUPIED)) | (~free & (belief == FREE)))
    return np.flatnonzero(agree)


@kernel()
def _free_share(belief: np.ndarray, covers: np.ndarray) -> np.ndarray:
    """Return the share of chains in which each cell is free, (C,), among those that agree with the belief if any do."""
    chains, share = _agreeing(belief, covers), np.zeros(belief.shape[0])
    if chains.shape[0] == 0:
        chains = np.arange(covers.shape[0])
    for k in chains:
        share += covers[k] == 0
    mean: np.ndarray = share / chains.shape[0]
    return mean


def _places(source: ThesisMaps) -> list[list[int]]:
    """Return the flat cells of every rectangle that the generator may draw, each as likely as the others."""
    sides = range(source.obstacle_size[0], source.obstacle_size[1] + 1)
    tops = range(source.margin, source.margin + max(source.height - 1 - 2 * source.margin, 1))
    lefts = range(source.margin, source.margin + max(source.width - 1 - 2 * source.margin, 1))
    return [
        [
            row * source.width + col
            for row in range(top, min(top + tall, source.height))
            for col in range(left, min(left + wide, source.width))
        ]
        for top in tops
        for left in lefts
        for tall in sides
        for wide in sides
    ]


def _padded(lists: list[list[int]]) -> NDArray[np.int32]:
    """Return lists of numbers as the rows of an array, padded with -1."""
    rows = np.full((len(lists), max(map(len, lists), default=0)), -1, np.int32)
    for row, numbers in zip(rows, lists, strict=True):
        row[: len(numbers)] = numbers
    return rows


class RoomPrior:
    """Use the generator's statistics: number, sizes and places of rectangles; never its map."""

    #: Places that rectangles can have at most; beyond, sampling takes too long.
    MOST_PLACES = 2000

    def __init__(self, source: ThesisMaps, rng: np.random.Generator, chains: int, sweeps: int) -> None:
        places = _places(source)
        covering: list[list[int]] = [[] for _ in range(source.height * source.width)]
        for number, cells in enumerate(places):
            for cell in cells:
                covering[cell].append(number)
        self._places, self._covering, self._sweeps = _padded(places), _padded(covering), sweeps
        self._key, self._updates = int(rng.integers(2**63)), 0
        self._chains = rng.integers(len(places), size=(chains, source.obstacles)).astype(np.int32)
        self._covers = np.zeros((chains, source.height * source.width), np.int32)
        for chain, covers in zip(self._chains, self._covers, strict=True):
            for place in chain:
                covers[places[place]] += 1

    @classmethod
    def suits(cls, source: object) -> bool:
        """Tell whether the maps come from a generator that this prior supports, and are small enough."""
        if not isinstance(source, ThesisMaps) or source.rows > 0:
            return False
        sides = (source.obstacle_size[1] - source.obstacle_size[0] + 1) ** 2
        return source.height * source.width * sides <= cls.MOST_PLACES

    def free_chances(self, belief: Belief) -> NDArray[np.float64]:
        """Return the probability that each cell of a (H, W) belief is free, (H*W,)."""
        cells = belief.ravel()
        for _ in range(self._sweeps):
            self._updates += 1
            key = np.uint64(draw(np.uint64(self._key), np.uint64(self._updates)))
            _sweep(cells, self._places, self._covering, self._chains, self._covers, key)
        return np.asarray(_free_share(cells, self._covers))

    def rooms(self, belief: Belief) -> Belief:
        """Return the latest samples that agree with a (H, W) belief, (K, H*W) without unknown cells."""
        covers = self._covers[_agreeing(belief.ravel(), self._covers)]
        return np.where(covers > 0, np.uint8(OCCUPIED), np.uint8(FREE))
