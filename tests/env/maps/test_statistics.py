"""Statistics of maps: exact on floors drawn by hand, the same for turned and padded ones."""

import numpy as np
import pytest

from indoor_explorers.env.maps.sources import FloorsMaps
from indoor_explorers.env.maps.statistics import STATISTICS, furniture_share, map_statistics, straight_share


def test_a_pillar_is_furniture():
    free = np.pad(np.ones((10, 12), np.bool_), 1)
    free[5, 6] = False
    assert furniture_share(free) == 1 / 120
    free[2:5, 2:8] = False
    assert furniture_share(free) == 0.0  # now one piece of 19 cells


def test_walls_are_straight_in_runs():
    assert straight_share(np.pad(np.ones((5, 9), np.bool_), 1)) == 1.0
    assert straight_share(np.pad(np.ones((5, 4), np.bool_), 1)) == 10 / 18
    assert straight_share(np.pad(np.eye(5, dtype=np.bool_), 1)) == 0.0


def test_statistics_do_not_depend_on_the_space_around_nor_on_mirrors():
    free = FloorsMaps(turned=0.0, ragged=0.0).draw(np.random.default_rng(4))
    plain, padded, mirrored = (map_statistics(each) for each in (free, np.pad(free, 7), free.T[::-1]))
    assert list(plain) == [kind.name for kind in STATISTICS]
    for name, values in plain.items():
        assert sorted(values) == pytest.approx(sorted(padded[name]))
        assert sorted(values) == pytest.approx(sorted(mirrored[name]))
    assert plain["floor"].tolist() == [free.sum()]
    assert len(plain["width"]) == free.sum()


def test_a_floor_of_one_cell_has_statistics():
    found = map_statistics(np.pad(np.ones((1, 1), np.bool_), 1))
    assert (found["floor"].tolist(), found["free share"].tolist(), found["loops"].tolist()) == ([1.0], [1.0], [0.0])
    assert found["room"].tolist() == [1.0]
