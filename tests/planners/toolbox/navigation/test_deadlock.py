from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import make_policy
from indoor_explorers.env.grid.arrays import Belief, Cell, Mask
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.planners.toolbox.navigation.deadlock import CHOICE, passing_places, path_to_passing_place
from indoor_explorers.planners.toolbox.navigation.paths import Paths
from tests.marks import spread
from tests.planners.flights import fly


def corridor(length: int, dead_ended: bool) -> Mask:
    """A room and a one-wide corridor, with another room at its far end or none."""
    free = np.zeros((7, length + 12), np.bool_)
    free[1:6, 1:6] = True
    free[3, 1 : length + 11] = True
    if not dead_ended:
        free[1:6, length + 6 : length + 11] = True
    return free


@pytest.mark.parametrize(
    ("team", "dead_ended", "radio"),
    spread([2, 4, 6], [False, True], [("none", 0.0), ("square", 3.0), ("unlimited", 0.0)]),
)
def test_uavs_in_a_row_get_past_each_other(team: int, dead_ended: bool, radio: tuple[str, float]) -> None:
    for length in (5, 12, 25):
        first = 6 + length // 2 - team // 2
        spawns = np.random.default_rng(length).permutation([(3, first + k) for k in range(team)]).tolist()
        flight = fly(
            make_policy("frontier-joint"),
            corridor(length, dead_ended),
            team=team,
            radio=radio,
            spawns=[(row, col) for row, col in spawns],
            goal_of="agent",
            lidar=1.0,
            budget=2500,
        )
        assert (flight.world.state.end == 1).all()
        assert flight.longest_dither <= 6


def test_passing_places_have_three_free_neighbours(belief: Belief) -> None:
    height, width = belief.shape
    for row in range(height):
        for col in range(width):
            around = [(row + 1, col), (row - 1, col), (row, col + 1), (row, col - 1)]
            free = sum(0 <= r < height and 0 <= c < width and belief[r, c] == FREE for r, c in around)
            assert passing_places(belief)[row, col] == (belief[row, col] == FREE and free >= 3)


def test_paths_lead_to_one_of_the_nearest_passing_places(belief: Belief, start: Cell) -> None:
    steps = distance_field(belief, start)
    within = np.sort(steps[passing_places(belief) & (steps > 0) & (steps <= 9)])
    path = path_to_passing_place(Paths(belief.shape), belief, start, 9, np.random.default_rng(0))
    if len(within) == 0:
        assert path is None
    else:
        assert path is not None
        assert path[0] == start
        assert passing_places(belief)[path[-1]]
        assert len(path) - 1 == steps[path[-1]] <= within[:CHOICE][-1]


def test_no_passing_place_behind_a_teammate() -> None:
    belief = np.where(corridor(8, True), 1, 2).astype(np.uint8)
    paths, rng = Paths(belief.shape), np.random.default_rng(0)
    assert path_to_passing_place(paths, belief, (3, 12), 30, rng, [(3, 9)]) is None
    path = path_to_passing_place(paths, belief, (3, 12), 30, rng, [(3, 14)])
    assert path is not None
    assert path[-1][1] <= 6
