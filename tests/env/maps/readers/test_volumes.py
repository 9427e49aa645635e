"""Maps of several levels from files of NumPy, alone and beside maps of fewer levels."""

import pickle

import numpy as np
import pytest

from indoor_explorers.env import InputError, World
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.maps.files import read_map
from indoor_explorers.env.maps.floorplan import Floorplan
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


@pytest.fixture
def others(tower):
    """Files of the building of three levels, of one of two levels, and of a plain map."""
    path, walls = tower
    np.save(path.with_name("low.npy"), walls[:2])
    np.save(path.with_name("plain.npy"), walls[0, :5])
    return tuple(str(path.with_name(name)) for name in ("plain.npy", "low.npy", "tower.npy"))


@pytest.mark.parametrize("order", [slice(None), slice(None, None, -1)])
def test_maps_of_fewer_levels_get_solid_ones_on_top(others, order):
    maps = FileMaps(paths=others[order])
    plans = sorted((maps.floorplan(index, 0) for index in range(3)), key=lambda plan: -plan.added)
    assert maps.level_count == maps.without_files().level_count == 3
    assert [(plan.name, plan.level_count, plan.added) for plan in plans] == [
        ("plain", 3, 2),
        ("low", 3, 1),
        ("tower", 3, 0),
    ]
    for plan, path in zip(plans, others, strict=True):
        own = read_map(path)
        free, below = (np.array(each.levels.volume(each.truth)) == FREE for each in (plan, own))
        np.testing.assert_array_equal(free[: len(below)], below)
        assert not free[len(below) :].any()
        assert (plan.digest, plan.layout) == (own.digest, own.layout)
        assert plan.main_part.sum() == own.main_part.sum()
        assert (sent := pickle.loads(pickle.dumps(plan))).digest == own.digest
        assert sent.added == plan.added


def test_a_map_alone_is_the_file_s_own_unless_more_levels_are_asked_for(others):
    for path in others:
        alone, own = FileMaps(paths=(path,)), read_map(path)
        plan = alone.floorplan(0, 0)
        assert (plan.shape, plan.level_count, plan.added) == (own.shape, own.level_count, 0)
        asked = FileMaps(paths=(path,), least_levels=3)
        assert asked.level_count == 3
        assert asked.identity() == alone.identity()
    assert FileMaps(paths=others[2:], least_levels=2).level_count == 3


def test_levels_are_counted_in_the_files_that_are_there(others):
    maps = FileMaps(paths=others)
    assert FileMaps.model_validate(maps.model_dump() | {"paths": others[:2]}).level_count == 2
    away = tuple(f"away-{path.rpartition('/')[2]}" for path in others)
    assert FileMaps.model_validate(maps.model_dump() | {"paths": away}).level_count == 3


def test_levels_that_were_solid_before_count_in_the_digest():
    free = np.ones((3, 4, 4), np.bool_)
    free[2] = False
    own, raised = Floorplan.from_free(free, "own"), Floorplan.from_free(free[:2], "own").raised(3)
    np.testing.assert_array_equal(own.truth, raised.truth)
    assert own.digest != raised.digest == Floorplan.from_free(free[:2], "own").digest
    assert own.raised(2) is own
    assert raised.raised(5).digest == raised.digest


def test_a_uav_explores_each_of_several_maps_with_all_levels(others):
    task = on_files(others, None)
    for index in range(3):
        world = World(task)
        world.reset(seeds=[1], index=index)
        assert world.floorplan(0).level_count == 3
        assert len(world.view(0, 0).legal) == 7
