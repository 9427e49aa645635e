from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import lil_matrix
from scipy.sparse.linalg import spsolve

from indoor_explorers.env import make_policy
from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import FREE, MOVES, OCCUPIED, UNKNOWN, UNREACHABLE
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.planners.swarm.hedac import SINK, climb, heat_up, sweep
from tests.planners.flights import fly, rooms

NOBODY = np.empty((0, 2))


def heat_of(belief: Belief, claims: np.ndarray = NOBODY, sinks: np.ndarray = NOBODY) -> np.ndarray:
    heat = np.empty(belief.shape)
    heat_up(belief, claims, 3.0, 0.25, sinks.astype(np.int64), heat, 0)
    return heat


def solved(belief: Belief, heat: np.ndarray, loss: float) -> np.ndarray:
    """The field as the solution of one system of equations."""
    matrix, right = lil_matrix((belief.size, belief.size)), np.zeros(belief.size)
    for row, col in np.ndindex(*belief.shape):
        k = row * belief.shape[1] + col
        matrix[k, k] = 1.0
        if belief[row, col] == OCCUPIED or heat[row, col] == SINK:
            continue
        beside = [(row + r, col + c) for r, c in MOVES[:4].tolist()]
        inside = [(r, c) for r, c in beside if 0 <= r < belief.shape[0] and 0 <= c < belief.shape[1]]
        passable = [(r, c) for r, c in inside if belief[r, c] != OCCUPIED]
        for r, c in passable:
            matrix[k, r * belief.shape[1] + c] = -1.0 / (len(passable) + loss)
        right[k] = heat[row, col] / (len(passable) + loss)
    return np.asarray(spsolve(matrix.tocsr(), right)).reshape(belief.shape)


@pytest.mark.parametrize("loss", [0.5, 10.0])
def test_sweeps_settle_at_the_solution(belief: Belief, start: Cell, loss: float) -> None:
    heat, field = heat_of(belief, np.array([[4.0, 5.0]]), np.array([start])), np.zeros(belief.shape)
    for _ in range(200):
        sweep(field, belief, heat, loss)
    assert field == pytest.approx(solved(belief, heat, loss), rel=1e-6, abs=1e-12)
    assert field[start] == 0.0


@pytest.mark.parametrize("loss", [0.1, 10.0])
def test_the_settled_field_can_be_climbed_from_everywhere(belief: Belief, loss: float) -> None:
    heat, field = heat_of(belief), np.zeros(belief.shape)
    for _ in range(400):
        sweep(field, belief, heat, loss)
    beside = np.pad(belief, 1, constant_values=OCCUPIED)
    frontier = (belief == FREE) & (
        (beside[2:, 1:-1] == UNKNOWN)
        | (beside[:-2, 1:-1] == UNKNOWN)
        | (beside[1:-1, 2:] == UNKNOWN)
        | (beside[1:-1, :-2] == UNKNOWN)
    )
    for row, col in np.argwhere(belief == FREE).tolist():
        steps = distance_field(belief, (row, col))
        end = climb(field, belief, row, col)
        if (steps[frontier] < UNREACHABLE).any():
            assert frontier.flat[end]
            assert steps.flat[end] < UNREACHABLE
        else:
            assert end == -1


def test_claims_cool_and_only_the_unknown_is_warm() -> None:
    belief = np.array([[FREE, UNKNOWN, UNKNOWN, OCCUPIED, UNKNOWN, UNKNOWN, FREE]], np.uint8)
    heat = heat_of(belief, np.array([[0.0, 1.0]]), np.array([[0, 6]]))
    assert heat.tolist() == [[0.0, 0.25, 0.25, 0.0, 0.25, 1.0, SINK]]


def test_fields_are_climbed_in_rooms() -> None:
    flight = fly(make_policy("hedac"), rooms(3, 5, 1), team=2, radio=("unlimited", 0.0))
    assert flight.complete
