"""A cover sees the whole frontier from near, and the tour through it goes on as long as it is worth it."""

import numpy as np
import pytest

from indoor_explorers.env.grid.cells import FREE, UNREACHABLE
from indoor_explorers.env.search.frontiers import frontier_mask
from indoor_explorers.planners.sampling.cover_tour import CoverTour, CoverTourPilot, visible_frontier
from indoor_explorers.planners.toolbox.navigation.paths import Paths
from tests.planners import flights

#: 0 unknown, 1 free, 2 occupied. The frontier: (1, 1), (1, 7), (3, 7), and (5, 1), which cannot be reached.
BELIEF = np.array(
    [
        [2, 0, 2, 2, 2, 2, 2, 2, 2],
        [2, 1, 1, 1, 1, 1, 1, 1, 0],
        [2, 2, 1, 2, 2, 2, 2, 2, 2],
        [2, 1, 1, 1, 1, 1, 1, 1, 0],
        [2, 2, 2, 2, 2, 2, 2, 2, 2],
        [0, 1, 2, 2, 2, 2, 2, 2, 2],
    ],
    np.uint8,
)


@pytest.mark.parametrize(
    ("cell", "reach", "seen"),
    [((1, 4), 3.0, 2), ((1, 4), 2.9, 0), ((1, 5), 3.0, 1), ((3, 5), 9.0, 1), ((3, 7), 9.0, 1), ((3, 3), 9.0, 2)],
    ids=["both ends", "too far", "one end", "not through the wall", "itself", "through the gap"],
)
def test_the_frontier_is_seen_from_near_through_known_cells(cell, reach, seen) -> None:
    steps = Paths(BELIEF.shape).field(BELIEF, (1, 4))
    assert frontier_mask(BELIEF).sum() == 4
    cells = np.array([cell[0] * BELIEF.shape[1] + cell[1]], np.int32)
    assert int(np.bitwise_count(visible_frontier(BELIEF, steps, cells, reach)).sum()) == seen


def test_the_stops_of_a_tour_see_all_that_any_viewpoint_sees(monkeypatch) -> None:
    checked = []

    def checking(pilot, view, viewpoints, bits):
        stops = tour(pilot, view, viewpoints, bits)
        every, chosen = (np.bitwise_or.reduce(each, axis=0) for each in (bits, bits[np.isin(viewpoints.cells, stops)]))
        steps = pilot.steps_from(view, view.cell).ravel()[stops]
        checked.append(np.array_equal(every, chosen) and (view.belief.ravel()[stops] == FREE).all())
        assert (steps < UNREACHABLE).all()
        return stops

    tour = CoverTourPilot._tour
    monkeypatch.setattr(CoverTourPilot, "_tour", checking)
    free = flights.maze(5, 5, 4)
    assert flights.fly(CoverTour(stops=200), free, budget=1500).complete
    assert len(checked) > 20
    assert all(checked)


def test_the_published_tour_is_the_shortest(monkeypatch) -> None:
    """The same covers, in the order of least length: never longer than the one of the highest value."""
    lengths: dict[bool, list[float]] = {True: [], False: []}
    choose = CoverTour.best_tour

    def both(policy, costs, tours, rate):
        for published in lengths:
            order = choose(policy, costs, tours, 0.0 if published else 0.5)
            lengths[published].append(costs[order[:-1], order[1:]].sum())
        return choose(policy, costs, tours, rate)

    monkeypatch.setattr(CoverTour, "best_tour", both)
    assert flights.fly(CoverTour(as_published=True), flights.maze(4, 4, 2), budget=900).complete
    shortest, others = np.array(lengths[True]), np.array(lengths[False])
    assert len(others) > 10
    assert shortest.sum() < others.sum()
