from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.sensing.lidar import lidar_model
from indoor_explorers.planners.pomdp.tree import CLASSES, Problem, isolation_weights, observation, search

LIDAR = lidar_model(1.0)


def corridor(left: int, right: int, known: tuple[int, int] = (8, 13), length: int = 21) -> Problem:
    """A known part of a corridor, and one completion that continues ``left`` and ``right`` of it for some cells."""
    belief: Belief = np.full((1, length), UNKNOWN, np.uint8)
    belief[0, known[0] : known[1]] = FREE
    completion, owners = belief.copy(), np.full((1, length), -1, np.int16)
    completion[belief == UNKNOWN] = OCCUPIED
    completion[0, known[0] - left : known[0]] = completion[0, known[1] : known[1] + right] = FREE
    owners[0, known[0] - left : known[0]], owners[0, known[1] : known[1] + right] = 0, 1
    return Problem(
        belief=belief,
        start=10,
        goals=np.array([known[0], known[1] - 1], np.int32),
        maps=completion[None],
        owners=owners,
        factors=np.ones(2),
        weights=isolation_weights(belief, 0.0),
        discount=1.0,
        horizon=30,
    )


def found(problem: Problem, simulations: int = 2, depth: int = 1) -> tuple[list[float], list[int]]:
    values, visits = search(problem, LIDAR, simulations, depth, 1.0)
    return values.tolist(), visits.tolist()


def test_a_return_is_all_that_becomes_known_and_discounted() -> None:
    assert found(corridor(3, 4)) == ([7.0, 7.0], [1, 1])
    values, _ = found(corridor(3, 0)._replace(discount=0.5))
    assert values[0] == pytest.approx(0.5**2 + 0.5**3 + 0.5**4)
    assert values[1] < values[0] / 4


def test_nothing_counts_beyond_the_horizon() -> None:
    assert found(corridor(6, 6)._replace(horizon=4))[0] == [3.0, 3.0]


def test_weights_and_factors_count() -> None:
    problem = corridor(2, 2)._replace(factors=np.array([1.0, 0.25]), horizon=3)
    assert found(problem)[0] == [2.0, 0.5]


def test_isolated_cells_weigh_more() -> None:
    belief = np.full((9, 9), FREE, np.uint8)
    belief[4, 4] = UNKNOWN
    weights = isolation_weights(belief, 8.0).reshape(9, 9)
    assert weights[4, 4] == 9.0
    assert weights.sum() == 9.0
    open_cells = isolation_weights(np.full((9, 9), UNKNOWN, np.uint8), 8.0).reshape(9, 9)
    assert open_cells[4, 4] == 1.0


def test_observations_are_classes_of_size() -> None:
    assert [observation(size) for size in (0, 1, 3, 4, 15, 16, 63, 64, 500)] == [0, 1, 1, 2, 2, 3, 3, 4, 4]
    assert CLASSES == 5


def test_simulations_go_to_the_better_action_but_try_all() -> None:
    problem = corridor(1, 8)._replace(discount=0.8)
    values, visits = found(problem, simulations=60, depth=2)
    assert values[1] > values[0]
    assert visits[1] > visits[0] >= 1
    assert sum(visits) == 60


def test_all_actions_are_judged_by_the_same_completions() -> None:
    two = [corridor(4, 0), corridor(0, 4)]
    problem = two[0]._replace(
        maps=np.concatenate([each.maps for each in two]),
        owners=np.concatenate([each.owners for each in two]),
        discount=0.9,
    )
    values, visits = found(problem, simulations=400)
    assert values[0] == pytest.approx(values[1], rel=0.05)
    assert min(visits) > 100


def test_the_belief_of_the_problem_is_left_alone() -> None:
    problem = corridor(5, 5)
    before = problem.belief.copy()
    found(problem, simulations=20, depth=3)
    assert np.array_equal(problem.belief, before)


def test_where_nothing_is_behind_the_frontiers_returns_are_zero() -> None:
    values, visits = found(corridor(0, 0), simulations=10, depth=3)
    assert values == [0.0, 0.0]
    assert min(visits) >= 1
    assert sum(visits) == 10
