"""The world on maps of several levels."""

import numpy as np
import pytest

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN, Action
from indoor_explorers.env.grid.levels import ASCEND, DESCEND, Levels
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.state import End
from indoor_explorers.env.simulation.world import World
from indoor_explorers.planners.frontier.nearest import FrontierNearest

STOREYS = {"map.source": "storeys", "map.height": 16, "map.width": 18, "map.room_size": [3, 6], "map.hall_size": [3, 5]}


def scenario(**settings):
    """A building of two storeys of three levels."""
    return Scenario().with_settings(STOREYS | settings).for_evaluation()


def small(volume, spawns, **settings):
    """A world on one given volume (L, H, W), free where True."""
    one_storey = {"map.storeys": 1, "map.storey_height": len(volume), "team": len(spawns)}
    world = World(scenario(**one_storey, **settings))
    world.begin(0, 1, floorplan=Floorplan.from_free(volume, "small"), spawns=spawns)
    return world


def test_moves_lead_up_and_down_and_end_at_obstacles_and_the_map():
    volume = np.ones((3, 4, 5), bool)
    volume[2, 1, 1] = False
    world = small(volume, [(0, 1, 1)], on_collision="block")
    levels = world.briefing(0, 0).levels
    assert tuple(levels) == (3, 4, 5)
    assert world.view(0, 0).legal.tolist() == [True] * 5 + [True, False]
    world.step([[ASCEND]])
    assert levels.voxel(world.view(0, 0).cell) == (1, 1, 1)
    assert world.view(0, 0).legal.tolist() == [True] * 5 + [False, True]
    world.step([[ASCEND]])
    assert world.state.collisions.tolist() == [[1]]
    world.step([[DESCEND]])
    world.step([[DESCEND]])
    assert levels.voxel(world.view(0, 0).cell) == (0, 1, 1)
    assert world.state.collisions.tolist() == [[2]]
    assert world.state.path_length.tolist() == [[2]]


def test_a_uav_that_flies_off_the_lowest_level_ends_out_of_bounds():
    world = small(np.ones((2, 3, 3), bool), [(0, 1, 1)])
    world.step([[DESCEND]])
    assert world.state.end.tolist() == [[End.OUT_OF_BOUNDS]]


def test_nobody_flies_through_the_rows_between_the_levels():
    world = small(np.ones((2, 3, 3), bool), [(0, 2, 1)], on_collision="block")
    world.step([[Action.DOWN]])
    assert world.briefing(0, 0).levels.voxel(world.view(0, 0).cell) == (0, 2, 1)
    assert world.view(0, 0).legal.tolist() == [False, True, True, True, True, True, False]


def test_uavs_block_each_other_on_the_way_up():
    world = small(np.ones((2, 3, 3), bool), [(0, 1, 1), (1, 1, 1)])
    world.step([[ASCEND, Action.STAY]])
    assert world.state.blocked.tolist() == [[1, 0]]


def test_beliefs_begin_with_the_rows_between_the_levels_alone():
    world = small(np.ones((3, 9, 9), bool), [(0, 4, 4)], **{"lidar.range": 2.0})
    view, levels = world.view(0, 0), world.briefing(0, 0).levels
    assert (view.belief[levels.between] == OCCUPIED).all()
    known = np.argwhere(levels.volume(view.belief) != UNKNOWN)
    np.testing.assert_array_equal(((known - (0, 4, 4)) ** 2).sum(axis=1) <= 4, True)
    assert len(known) == world.state.covered[0, 0] == world.state.known[0, 0]


@pytest.mark.parametrize(("model", "reach", "linked"), [("disc", 2.9, False), ("disc", 3.0, True), ("square", 2, True)])
def test_radios_reach_through_slabs_by_distance_in_three_dimensions(model, reach, linked):
    volume = np.ones((3, 5, 5), bool)
    volume[1] = False
    volume[1, 4, 4] = True
    world = small(volume, [(0, 1, 1), (2, 2, 3)], **{"radio.model": model, "radio.range": reach})
    assert world.state.linked[0, 0, 1] == linked  # 2 levels, 1 row, 2 columns away


def test_the_base_is_in_contact_by_distance_in_three_dimensions():
    world = small(np.ones((4, 3, 3), bool), [(0, 1, 1)], **{"base.at": "start", "base.radius": 1.5, "lidar.range": 1.0})
    ages = []
    for _ in range(3):
        world.step([[ASCEND]])
        ages.append(world.view(0, 0).base_age)
    assert ages == [0, 1, 2]


@pytest.mark.parametrize("seed", range(3))
def test_coverage_counts_the_free_cells_that_can_be_reached(seed):
    world = World(scenario())
    world.reset([seed])
    plan = world.floorplan(0)
    free = plan.levels.volume(plan.truth) == FREE
    assert world.state.total[0] == free.sum() == plan.main_part.sum()


def test_nearest_frontier_explores_all_storeys_of_every_seed_without_a_collision():
    world = World(scenario(team=2, **{"lidar.range": 4.0, "radio.model": "disc", "radio.range": 8.0}), 4)
    world.reset([1, 2, 3, 4])
    pilots = [[FrontierNearest().pilot(world.briefing(b, n)) for n in range(2)] for b in range(4)]
    while world.flying.any():
        world.step([[pilot.act(world.view(b, n)) for n, pilot in enumerate(row)] for b, row in enumerate(pilots)])
    assert (world.team_coverage == 1.0).all()
    assert not world.state.collisions.any()
    assert (world.state.end == End.GOAL).all()


def test_a_volume_of_one_level_is_a_plain_map():
    free = np.random.default_rng(1).random((12, 10)) < 0.7
    plain, volume = Floorplan.from_free(free, "map"), Floorplan.from_free(free[None], "map")
    assert volume.level_count == 1
    assert volume.digest == plain.digest
    assert Scenario().with_settings({**STOREYS, "map.storeys": 1, "map.storey_height": 1}).actions == 5


def test_maps_of_other_numbers_of_levels_are_refused():
    world = World(scenario())
    with pytest.raises(InputError, match="flat: expected a map of 7 levels, got 2"):
        world.begin(0, 1, floorplan=Floorplan.from_free(np.ones((2, 16, 18), bool), "flat"))


@pytest.mark.parametrize(
    ("settings", "named"),
    [
        ({"lidar.model": "marsexplorer"}, "lidar.model exact and lidar.field_of_view 360, got marsexplorer"),
        ({"lidar.field_of_view": 90.0}, "lidar.field_of_view 360, got exact, 90"),
        ({"radio.model": "path-loss", "radio.range": 9.0}, "none, square, disc or unlimited, got path-loss"),
        ({"drift.rate": 0.01}, "a world without noise and drift; remove them"),
        ({"prior.kind": "right"}, "prior.kind none, got right"),
        ({"denominator": "map"}, "denominator reachable, got map"),
        ({"base.at": [3, 3]}, r"base.at start or none, got \[3, 3\]"),
    ],
)
def test_what_does_not_work_on_levels_is_refused_in_one_line(settings, named):
    with pytest.raises(InputError, match=f"maps of several levels need .*{named}"):
        Scenario().with_settings(STOREYS | settings)


def test_levels_have_fingerprints_of_their_own_and_elevations_too():
    tall = scenario()
    assert tall.fingerprint != scenario(**{"map.storeys": 3}).fingerprint
    assert tall.fingerprint != scenario(**{"lidar.elevation": 15.0}).fingerprint
    assert Levels.of((7 * 17 - 1, 18), 7) == World(tall)._preparation.drawn([0], [1], 0, None).floorplans[0].levels
