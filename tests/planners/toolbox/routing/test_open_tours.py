from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from numpy.typing import NDArray

from indoor_explorers.planners.toolbox.routing.open_tours import (
    Costs,
    improved,
    nearest_neighbour,
    open_tour,
    shared_out,
)


def matrix(kind: str, count: int, seed: int) -> Costs:
    """Costs of going between ``count`` places."""
    rng = np.random.default_rng(seed)
    if kind == "asymmetric":
        return rng.random((count, count)) * 100
    points = rng.integers(0, 50, (count, 2))
    steps = np.abs(points[:, None] - points[None]).sum(axis=2)
    return np.asarray(steps, np.int32) if kind == "steps" else np.asarray(steps * 0.37)


def tour_length(costs: Costs, order: NDArray[np.int64]) -> float:
    return float(costs[order[:-1], order[1:]].sum())


def shortest(costs: Costs, first: int) -> float:
    others = [place for place in range(len(costs)) if place != first]
    return min(tour_length(costs, np.array([first, *order])) for order in permutations(others))


def with_cheapest(costs: Costs, order: NDArray[np.int64], place: int) -> NDArray[np.int64]:
    longer = [np.insert(order, at, place) for at in range(1, len(order) + 1)]
    return min(longer, key=lambda tour: tour_length(costs, tour))


def assert_visits_all(order: NDArray[np.int64], count: int, first: int) -> None:
    assert order[0] == first
    assert sorted(order.tolist()) == list(range(count))


@pytest.mark.parametrize("kind", ["steps", "scaled", "asymmetric"])
@pytest.mark.parametrize("count", [1, 2, 3, 7, 30])
def test_no_step_makes_a_tour_longer(kind: str, count: int) -> None:
    for seed in range(10):
        costs, first = matrix(kind, count, seed), seed % count
        greedy = nearest_neighbour(costs, first)
        others = [place for place in range(count) if place != first]
        for start in (greedy, np.array([first, *np.random.default_rng(seed).permutation(others)], np.int64)):
            before = start.copy()
            better = improved(costs, start)
            assert_visits_all(better, count, first)
            assert tour_length(costs, better) <= tour_length(costs, start) + 1e-9
            assert (start == before).all()


@pytest.mark.parametrize("kind", ["steps", "scaled", "asymmetric"])
def test_small_tours_are_nearly_always_as_short_as_can_be(kind: str) -> None:
    found, best = [], []
    for seed in range(40):
        count = 3 + seed % 5
        costs, first = matrix(kind, count, seed), seed % count
        order = open_tour(costs, first)
        assert_visits_all(order, count, first)
        found.append(tour_length(costs, order))
        best.append(shortest(costs, first))
    ratios = np.array(found) / np.array(best)
    assert ratios.min() >= 1 - 1e-9
    assert ratios.mean() < 1.05
    assert (ratios < 1 + 1e-9).mean() > 0.6


@pytest.mark.parametrize("count", range(1, 8))
def test_up_to_three_places_are_optimal_and_equal_costs_do_no_harm(count: int) -> None:
    costs = matrix("asymmetric", min(count, 3), count)
    assert tour_length(costs, open_tour(costs)) == pytest.approx(shortest(costs, 0))
    assert_visits_all(open_tour(np.zeros((count, count)), count - 1), count, count - 1)


def test_the_nearest_comes_next_and_the_first_of_equals() -> None:
    costs = np.array([[0, 2, 2, 5], [2, 0, 9, 1], [2, 9, 0, 1], [5, 1, 1, 0]])
    assert nearest_neighbour(costs).tolist() == [0, 1, 3, 2]
    assert nearest_neighbour(costs, 3).tolist() == [3, 1, 0, 2]


def test_a_tour_along_a_line_turns_once() -> None:
    line = np.array([3, 0, 10, 1, 5, 9, 2])
    costs = np.abs(line[:, None] - line[None])
    assert line[open_tour(costs)].tolist() in ([3, 2, 1, 0, 5, 9, 10], [3, 5, 9, 10, 2, 1, 0])
    assert tour_length(costs, open_tour(costs)) == 13


def test_places_beyond_reach_come_last() -> None:
    costs = matrix("steps", 6, 1)
    costs[:, 2] = costs[2, :] = 2**30
    assert open_tour(costs).tolist()[-1] == 2


@pytest.mark.parametrize("kind", ["steps", "asymmetric"])
def test_places_are_shared_out_one_by_one_where_the_tour_stays_shortest(kind: str) -> None:
    for seed in range(10):
        costs, starts = matrix(kind, 9, seed), 1 + seed % 3
        tours = [np.array([i], np.int64) for i in range(starts)]
        left = list(range(starts, len(costs)))
        while left:
            grown = {(k, i): with_cheapest(costs, tours[i], k) for k in left for i in range(starts)}
            place, who = min(grown, key=lambda pair: (tour_length(costs, grown[pair]), *pair))
            tours[who] = grown[place, who]
            left.remove(place)
        owners = shared_out(costs, starts)
        assert all(owners[place - starts] == who for who in range(starts) for place in tours[who][1:])
