"""The surface of maps of several levels, and how much of it a team's map shows."""

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, World, make_policy
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.evaluation.harness.episodes.resimulate import on_levels, resimulate
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.episodes.surface import seen_share, surface_of
from indoor_explorers.evaluation.harness.experiment.experiment import Task

TASK = PRESETS["racks"].for_evaluation().with_settings({"team": 1, "budget": 40})


@pytest.fixture(scope="module")
def record():
    """An episode of 40 steps among racks."""
    return next(fly(make_policy("frontier-nearest"), "frontier-nearest", TASK, [Task(TASK.name, 0, 3)]))


def begun(free, spawn):
    world = World(on_levels(TASK, len(free)))
    world.begin(0, 1, floorplan=Floorplan.from_free(free, "small"), spawns=[spawn])
    return world


def test_the_surface_are_the_obstacles_that_share_a_face_with_a_free_voxel_that_can_be_reached():
    free = np.zeros((3, 5, 7), bool)
    free[1, 2, 1:4] = True
    free[1, 2, 5] = True  # closed off
    world = begun(free, (1, 2, 1))
    surface = surface_of(world, 0)
    levels = world.briefing(0, 0).levels
    expected = {(level, 2, col) for level in (0, 2) for col in (1, 2, 3)} | {(1, 2, 0), (1, 2, 4)}
    expected |= {(1, row, col) for row in (1, 3) for col in (1, 2, 3)}
    assert set(map(tuple, levels.voxels(np.argwhere(surface)).tolist())) == expected
    assert seen_share(world, 0, surface) == 1.0


def test_the_rows_between_levels_are_no_surface_and_without_any_all_is_seen():
    world = begun(np.ones((2, 3, 3), bool), (0, 1, 1))
    surface = surface_of(world, 0)
    assert not surface.any()
    assert seen_share(world, 0, surface) == 1.0


def test_a_team_at_one_end_of_a_long_duct_has_not_seen_the_surface_at_the_other():
    free = np.zeros((2, 3, 40), bool)
    free[0, 1, 1:39] = True
    world = begun(free, (0, 1, 1))
    surface = surface_of(world, 0)
    assert surface.sum() == 3 * 38 + 2
    assert 0.2 < seen_share(world, 0, surface) < 0.4


def test_episodes_on_levels_say_how_much_of_the_surface_they_saw(record):
    *_, world = resimulate(record, TASK)
    beside = surface_of(world, 0)
    assert 0.1 < record.metrics["surface"] < 1.0
    assert record.metrics["surface"] == seen_share(world, 0, beside)
    assert not (beside & (record.floorplan.truth == FREE)).any()


def test_a_move_up_or_down_is_one_cell_flown(record):
    assert max(np.abs(np.diff(record.cells[:, 0, 0].astype(int)))) > 20  # from level to level in the plane
    assert record.distance[-1] == record.metrics["path_length"]
    assert record.metrics["path_max_m"] is None


def test_plain_maps_have_no_such_metric():
    plain = PRESETS["thesis-open"].for_evaluation().with_settings({"budget": 2})
    (flown,) = fly(make_policy("random"), "random", plain, [Task(plain.name, 0, 1)])
    assert "surface" not in flown.metrics
