from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.planners.horizon.learned_prior import CONFIDENCE, FIRST_GUESS, LearnedPrior, obstacles_around


def test_obstacles_around_are_counted(belief: Belief) -> None:
    counts = obstacles_around(belief == OCCUPIED)
    for row, col in np.ndindex(*belief.shape):
        near = belief[max(0, row - 1) : row + 2, max(0, col - 1) : col + 2] == OCCUPIED
        assert counts[row, col] == near.sum() - (belief[row, col] == OCCUPIED)


def test_it_learns_from_what_is_revealed() -> None:
    belief = np.full((5, 5), UNKNOWN, np.uint8)
    belief[2, 2] = OCCUPIED
    prior = LearnedPrior()
    before = prior.free_chances(belief).reshape(5, 5)
    assert before[0, 0] == 1.0
    assert before[1, 1] == FIRST_GUESS[1]
    belief = belief.copy()
    belief[1, 1:4] = FREE, FREE, OCCUPIED
    after = prior.free_chances(belief).reshape(5, 5)
    assert after[3, 1] == (CONFIDENCE * FIRST_GUESS[1] + 2) / (CONFIDENCE + 3)
    assert after[0, 0] == 1.0
