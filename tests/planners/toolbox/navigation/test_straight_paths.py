from __future__ import annotations

from itertools import pairwise

import numpy as np

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import FREE, UNREACHABLE
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.planners.toolbox.navigation.straight_paths import straight_path


def test_straight_paths_are_shortest_paths(belief: Belief, start: Cell) -> None:
    field = distance_field(belief, start)
    for goal in map(tuple, np.argwhere(belief == FREE)[::3].tolist()):
        path = straight_path(belief, start, goal)
        if field[goal] == UNREACHABLE:
            assert path == []
            continue
        assert (path[0], path[-1], len(path)) == (start, goal, field[goal] + 1)
        for before, after in pairwise(path):
            assert abs(before[0] - after[0]) + abs(before[1] - after[1]) == 1
            assert belief[after] == FREE


def test_in_the_open_the_longer_axis_is_shortened_first() -> None:
    path = straight_path(np.ones((9, 9), np.uint8), (0, 0), (3, 6))
    assert path[:4] == [(0, 0), (0, 1), (0, 2), (0, 3)]
    assert {abs((3 - row) - (6 - col)) for row, col in path[3:]} == {0, 1}
