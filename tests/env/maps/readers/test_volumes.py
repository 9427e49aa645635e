"""Maps of several levels from files of NumPy."""

import numpy as np
import pytest

from indoor_explorers.env import InputError
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.maps.files import read_map
from indoor_explorers.env.maps.sources import FileMaps
from indoor_explorers.env.scenarios.presets import on_files


@pytest.fixture
def tower(tmp_path):
    """A file with a building of three levels, and the mask of its obstacles."""
    walls = np.random.default_rng(1).random((3, 8, 9)) < 0.3
    walls[:, 4, 4] = False
    walls[[1, 2, 2], [0, 1, 0], [0, 0, 1]], walls[2, 0, 0] = True, False  # a pocket
    np.save(tmp_path / "tower.npy", walls)
    return tmp_path / "tower.npy", walls


def test_a_volume_is_read_with_its_lowest_level_first(tower):
    path, walls = tower
    plan = read_map(path)
    free = np.array(plan.levels.volume(plan.truth)) == FREE
    assert plan.level_count == 3
    assert not (free & walls).any()
    assert free[:, 4, 4].all()
    assert plan.kept == free.sum() / (~walls).sum() < 1.0


def test_a_scenario_of_files_knows_their_levels_and_who_flies_does_too(tower):
    path, _ = tower
    task = on_files((str(path),), None)
    assert (task.map.level_count, task.actions) == (3, 7)
    assert task.map.without_files().level_count == 3
    assert FileMaps(paths=("nowhere.npy",)).level_count == 1


def test_the_number_of_an_occupancy_grid_s_level_is_told_where_it_is_wrong(tmp_path):
    values = np.zeros((2, 3, 4))
    values[1, 2, 3] = 1.5
    np.save(tmp_path / "odd.npy", values)
    with pytest.raises(InputError, match=r"got 1\.5 in level 1, row 2, column 3"):
        read_map(tmp_path / "odd.npy")


def test_volumes_are_not_resampled(tower):
    with pytest.raises(InputError, match=r"expected no --resolution for an array of several levels, got 2; omit it"):
        read_map(tower[0], 2.0)
