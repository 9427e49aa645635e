from __future__ import annotations

from itertools import permutations

import numpy as np

from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.planners.toolbox.routing.sequences import DecisionProblem, Utility, best_sequences, cost_of_rest

WORTH = Utility(0.5, 0.8, 0.5)


def a_task(rng: np.random.Generator, count: int, uavs: int = 1) -> DecisionProblem:
    points, own = 3.0 * rng.random((count, 2)), 3.0 * rng.random((uavs, 2))
    shared = rng.random((count, count)) * (rng.random((count, count)) < 0.4)
    np.fill_diagonal(shared, 1.0)
    return DecisionProblem(
        cells=np.arange(count, dtype=np.int32),
        ahead=np.ones(count, np.bool_),
        away=np.hypot(*(own[:, None] - points).transpose(2, 0, 1)),
        between=np.hypot(*(points[:, None] - points).transpose(2, 0, 1)),
        gains=10.0 * rng.random(count),
        shared=shared,
        hysteresis=np.where(rng.random((uavs, count)) < 0.2, 1.2, 1.0),
    )


def plain_value(problem: DecisionProblem, uav: int, sequence: tuple[int, ...]) -> float:
    total, time = 0.0, 0.0
    for k, place in enumerate(sequence):
        time += problem.between[sequence[k - 1], place] if k else problem.away[uav, place]
        left = problem.gains[place] * np.prod([1.0 - problem.shared[place, before] for before in sequence[:k]])
        total += (
            left**WORTH.power
            * np.exp(-WORTH.rate * time)
            * WORTH.trust**k
            * (1 if k else problem.hysteresis[uav, place])
        )
    return total


def test_sequences_are_the_best_of_all() -> None:
    rng = np.random.default_rng(4)
    for _ in range(20):
        problem = a_task(rng, int(rng.integers(1, 8)), 2)
        count = len(problem.cells)
        values, sequences = best_sequences(problem, 1, problem.gains, WORTH)
        for first in range(count):
            others = [place for place in range(count) if place != first]
            best = max(
                plain_value(problem, 1, (first, *rest))
                for length in range(min(3, count))
                for rest in permutations(others, length)
            )
            found = tuple(place for place in sequences[first].tolist() if place >= 0)
            assert found[0] == first
            assert np.isclose(values[first], best)
            assert np.isclose(plain_value(problem, 1, found), best)


def test_what_cannot_be_reached_is_worth_nothing() -> None:
    problem = a_task(np.random.default_rng(0), 5)
    problem.away[0, 2] = UNREACHABLE
    values, _ = best_sequences(problem, 0, problem.gains, WORTH)
    assert np.flatnonzero(values == 0.0).tolist() == [2]


def test_the_cost_of_the_rest_is_that_of_a_nearly_cheapest_order() -> None:
    rng = np.random.default_rng(7)
    excess = []
    for _ in range(30):
        problem = a_task(rng, 6)
        first, rest, weights = 3, np.array([0, 2, 4, 5]), rng.random(6)
        shares = weights / weights[[first, *rest]].sum()
        least = np.inf
        for order in permutations(rest.tolist()):
            times = problem.away[0, first] + np.cumsum([0.0, *problem.between[[first, *order[:-1]], order]])
            least = min(least, times[-1] + 3.0 * float(times @ shares[[first, *order]]))
        found = cost_of_rest(problem, 0, first, rest, weights, 3.0)
        assert found >= least - 1e-9
        excess.append(found / least - 1.0)
    assert np.mean(excess) < 0.01


def test_a_single_place_costs_the_way_to_it_and_its_wait() -> None:
    problem = a_task(np.random.default_rng(1), 3)
    alone = cost_of_rest(problem, 0, 1, np.empty(0, np.int64), np.ones(3), 3.0)
    assert np.isclose(alone, 4.0 * problem.away[0, 1])
