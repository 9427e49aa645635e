from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.maps.generators.thesis import ThesisMaps
from indoor_explorers.env.maps.sources import MazeMaps
from indoor_explorers.planners.horizon.learned_prior import CONFIDENCE, FIRST_GUESS, LearnedPrior, obstacles_around
from indoor_explorers.planners.horizon.room_prior import RoomPrior


def covered(source: ThesisMaps, tops: tuple[tuple[int, int], ...]) -> np.ndarray:
    room = np.zeros((source.height, source.width), np.bool_)
    for row, col in tops:
        room[row : row + 2, col : col + 2] = True
    return room


@pytest.mark.slow
def test_chances_are_those_of_all_rooms_that_agree_with_the_belief() -> None:
    source = ThesisMaps(height=6, width=7, obstacles=2, obstacle_size=(2, 2))
    belief = np.full((6, 7), UNKNOWN, np.uint8)
    belief[:3, :3] = FREE
    belief[2, 3] = OCCUPIED
    corners = list(product(range(1, 4), range(1, 5)))
    rooms = [covered(source, pair) for pair in product(corners, corners)]
    agreeing = [room for room in rooms if room[2, 3] and not room[:3, :3].any()]
    prior = RoomPrior(source, np.random.default_rng(0), 2000, 10)
    expected = 1.0 - np.mean(agreeing, axis=0)
    assert np.abs(prior.free_chances(belief) - expected.ravel()).max() < 0.06


def test_what_is_known_is_certain() -> None:
    source = ThesisMaps()
    truth = source.floorplan(0, 3).truth
    rng = np.random.default_rng(0)
    belief = np.where(rng.random(truth.shape) < 0.7, truth, UNKNOWN).astype(np.uint8)
    prior = RoomPrior(source, rng, 32, 10)
    for _ in range(3):
        chances = prior.free_chances(belief).reshape(truth.shape)
    assert (chances[belief == FREE] == 1.0).all()
    assert (chances[belief == OCCUPIED] == 0.0).all()
    assert chances.mean() > 0.5


def test_it_knows_which_generators_it_suits() -> None:
    assert RoomPrior.suits(ThesisMaps())
    assert not RoomPrior.suits(ThesisMaps(rows=2, columns=2))
    assert not RoomPrior.suits(ThesisMaps(height=200, width=200))
    assert not RoomPrior.suits(MazeMaps())


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
