"""The tour of one UAV through a small map: planned cell by cell, kept while it is valid, replanned as the map grows."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, UNKNOWN
from indoor_explorers.env.search.bitsets import Bits, around, hash_keys, packed, unpacked
from indoor_explorers.planners.horizon.beam import BeamConfig, SearchGraph, shortest_tour
from indoor_explorers.planners.horizon.learned_prior import Prior
from indoor_explorers.planners.horizon.rollout_choice import RolloutSelection
from indoor_explorers.planners.toolbox.information.optimistic_views import OptimisticViews

#: Expected number of free cells that may be missing if the goal is full coverage.
CERTAINTY = 0.2
#: Beam width in the search for alternatives, as a share of the usual width.
ALTERNATIVE_WIDTH = 0.4
#: Largest number of additional steps of an alternative that is tried in rollouts.
SLACK = 6


class TourProblem(NamedTuple):
    """The search problem of one tour."""

    cell: int
    """Flat start cell."""
    unseen: Bits
    """(W,) cells to be seen, without cells of weight 0, which are obstacles."""
    weights: NDArray[np.float64]
    """(C,) weight of seeing a cell."""
    rest: float
    """Total weight that may stay unseen."""


class TourPlanner:
    """Plan tours that view the share ``goal`` of the free cells; the share ``deferred_share`` of them comes last."""

    def __init__(
        self,
        shape: tuple[int, int],
        lidar_range: float,
        prior: Prior,
        config: BeamConfig,
        goal: float,
        deferred_share: float,
        selection: RolloutSelection | None = None,
    ) -> None:
        self.optimistic = OptimisticViews(shape, lidar_range)
        self._prior, self._config, self._goal, self._deferred_share = prior, config, goal, deferred_share
        self._selection = selection
        self._around, self._keys = around(shape), hash_keys(2 * shape[0] * shape[1])
        self._tour: list[int] = []
        self._finishes = False

    @property
    def tour(self) -> tuple[int, ...]:
        """The flat cells that are left of the tour."""
        return tuple(self._tour)

    @property
    def length(self) -> int:
        """Remaining steps of the tour."""
        return len(self._tour)

    def following(self, cell: int) -> int | None:
        """Return the next cell of the tour for a UAV in a flat cell; None if there is none."""
        if self._tour and self._tour[0] == cell:
            self._tour = self._tour[1:]
        stands = self._tour and self._tour[0] in self.optimistic.neighbours[cell]
        return self._tour[0] if stands else None

    def plan(self, belief: Belief, cell: int, share: NDArray[np.float64] | None = None) -> None:
        """Plan a tour from a flat cell; keep the old one while it is finished and not worse.

        ``share`` (C,) are factors on the cells' weights, below 1 for cells that teammates may see. An unfinished tour
        is kept while it can be flown and has a gain. With rollouts, and without teammates, a tour with another first
        step replaces it if that is better in sampled rooms.
        """
        self.optimistic.update(belief)
        self.following(cell)
        unseen = packed(belief == UNKNOWN) & self.optimistic.attainable(cell)
        chances = np.where(unpacked(unseen, belief.size), self._prior.free_chances(belief), 0.0)
        weights, rest = self._wanted(belief, chances, unseen, share)
        unseen = unseen & packed(weights > 0)
        problem = TourProblem(cell, unseen, weights, rest)
        old = self._cost(problem, self._tour)
        if old is not None:
            self._tour = self._tour[: old[0]]
        elif self._finishes or not self._is_open(problem) or not self._upto_last_gain(self._tour, unseen):
            self._tour = []
        depth = min(self._config.depth, old[0]) if old else self._config.depth
        tour, finishes = self._search(problem, self._config._replace(depth=depth))
        new = self._cost(problem, tour)
        if not self._tour or (new is not None and (old is None or new < old)):
            self._tour, self._finishes = tour, finishes
        if self._selection is not None and share is None and self._tour:
            tours = [(self._tour, self._finishes), *self._alternatives(problem)]
            if len(tours) > 1:
                best = self._selection.best(belief, cell, self.optimistic, chances, [tour for tour, _ in tours])
                self._tour, self._finishes = tours[best]

    def _alternatives(self, problem: TourProblem) -> list[tuple[list[int], bool]]:
        """Return a tour for each other first step, and whether it is finished; without much longer ones."""
        tours = []
        width = max(1, round(ALTERNATIVE_WIDTH * self._config.width))
        for cell in self.optimistic.neighbours[problem.cell].tolist():
            if cell < 0 or cell == self._tour[0]:
                continue
            after = problem._replace(cell=cell, unseen=problem.unseen & ~self.optimistic.views[cell])
            rest, finishes = self._search(after, self._config._replace(width=width))
            tour = [cell, *rest]
            shows = finishes or self._upto_last_gain(tour, problem.unseen)
            if shows and not (finishes and self._finishes and len(tour) > len(self._tour) + SLACK):
                tours.append((tour, finishes))
        return tours

    def _search(self, problem: TourProblem, config: BeamConfig) -> tuple[list[int], bool]:
        """Return a tour and whether it is finished; an unfinished one is cut after its last gain."""
        if not problem.unseen.any():
            return [], False
        views, neighbours, within = self.optimistic.views, self.optimistic.neighbours, self.optimistic.views_within
        graph = SearchGraph(views, neighbours, within, self._around, self._keys, problem.weights)
        cells, finishes = shortest_tour(problem.cell, problem.unseen, graph, problem.rest, config)
        tour = cells.tolist()
        return (tour, True) if finishes else (self._upto_last_gain(tour, problem.unseen), False)

    def _wanted(
        self, belief: Belief, chances: NDArray[np.float64], unseen: Bits, share: NDArray[np.float64] | None
    ) -> tuple[NDArray[np.float64], float]:
        """Return the weights of cells (C,) and the total weight that may stay unseen.

        The deferred share is left out until only that remains; then the teammates' cells are included, and in the end
        every cell, even if it is probably an obstacle.
        """
        total = np.count_nonzero(belief == FREE) + chances.sum()
        rest = (1.0 - self._goal) * total + CERTAINTY
        own = chances if share is None else chances * share
        for weights, most in ((own, max(rest, self._deferred_share * total)), (own, rest), (chances, rest)):
            if weights.sum() > most:
                return weights, most
        return unpacked(unseen, belief.size).astype(np.float64), 0.5

    def _cost(self, problem: TourProblem, tour: list[int]) -> tuple[int, float] | None:
        """Return the steps after which a tour is finished, and its delay; None if it is unfinished or blocked.

        The delay is the weight of the unseen cells, summed over these steps.
        """
        cell, unseen, delay = problem.cell, problem.unseen, 0.0
        for steps, following in enumerate(tour, 1):
            if following not in self.optimistic.neighbours[cell]:
                return None
            cell, unseen = following, unseen & ~self.optimistic.views[following]
            left = float(problem.weights[unpacked(unseen, problem.weights.size)].sum())
            delay += left
            if left <= problem.rest:
                return steps, round(delay, 6)
        return None

    def _is_open(self, problem: TourProblem) -> bool:
        """Tell whether no known obstacle blocks the old tour."""
        steps = zip([problem.cell, *self._tour], self._tour, strict=False)
        return all(after in self.optimistic.neighbours[before] for before, after in steps)

    def _upto_last_gain(self, tour: list[int], unseen: Bits) -> list[int]:
        last = 0
        for steps, cell in enumerate(tour, 1):
            if (unseen & self.optimistic.views[cell]).any():
                last, unseen = steps, unseen & ~self.optimistic.views[cell]
        return tour[:last]
