from __future__ import annotations

from math import exp

import numpy as np
import pytest

from indoor_explorers.env.grid.levels import Levels
from indoor_explorers.planners.swarm.aco import Pheromone, preferences, transition


def test_pheromone_falls_with_the_distance_and_evaporates() -> None:
    pheromone = Pheromone(Levels(1, 9, 9), 2.5, 2.0)
    pheromone.lay((4, 4), 3.0)
    assert pheromone.field[4, 4] == 3.0
    assert pheromone.field[4, 6] == pytest.approx(3.0 * exp(-1.0))
    assert pheromone.field[6, 6] == 0.0
    pheromone.evaporate(0.25)
    assert pheromone.field[4, 4] == 2.25


@pytest.mark.parametrize("cell", [(0, 0), (0, 6), (4, 0), (4, 6), (2, 3)])
def test_pheromone_is_cut_at_the_edge_of_the_map(cell: tuple[int, int]) -> None:
    pheromone, rows_cols = Pheromone(Levels(1, 5, 7), 3.0, 1.5), np.indices((5, 7))
    pheromone.lay(cell, 1.0)
    away = np.hypot(rows_cols[0] - cell[0], rows_cols[1] - cell[1])
    assert pheromone.field == pytest.approx(np.where(away <= 3.0, np.exp(-away / 1.5), 0.0))


def test_pheromone_repels_and_worth_attracts() -> None:
    weights = preferences(np.array([0.0, 1.0, 0.0]), np.array([2.0, 2.0, 1.0]), 2.0, 3.0)
    assert weights == pytest.approx([1.0, 1 / 4, 1 / 8])
    assert preferences(np.array([0.0, 5.0]), np.array([1.0, 1.0]), 0.0, 1.0).tolist() == [1.0, 1.0]
    assert preferences(np.array([1.0]), np.array([0.0]), 1.0, 2.0).tolist() == [1.0]


def test_a_choice_is_greedy_or_in_proportion() -> None:
    rng, weights = np.random.default_rng(2), np.array([0.25, 1.0, 0.0])
    assert {transition(weights, 1.0, rng) for _ in range(50)} == {1}
    counts = np.bincount([transition(weights, 0.0, rng) for _ in range(4000)], minlength=3)
    assert counts[0] / 4000 == pytest.approx(0.2, abs=0.03)
    assert counts[2] == 0
