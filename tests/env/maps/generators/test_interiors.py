"""Furnished buildings and warehouses of several levels."""

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from indoor_explorers.env import PRESETS
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.maps.generators.interiors import InteriorsMaps
from indoor_explorers.env.maps.generators.racks import RacksMaps
from indoor_explorers.env.maps.generators.volumes import wide
from indoor_explorers.env.search.connected_parts import connected_parts, largest_part

SIZE: dict[str, Any] = {"height": 24, "width": 30}
BARE = InteriorsMaps(**SIZE, furniture=0.0)
TALL = InteriorsMaps(**SIZE, furniture=0.0, storeys=2, storey_height=4)
NAMES = ("one-storey", "tall-halls", "racks", "stair-wells")


def volume_of(maps, seed):
    plan = maps.floorplan(0, seed)
    return np.array(plan.levels.volume(plan.truth)) == FREE


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("seed", range(5))
def test_all_free_cells_are_connected_and_walled_in_and_every_storey_is_there(name, seed):
    free = volume_of(PRESETS[name].map, seed)
    assert free.shape == (PRESETS[name].map.level_count, 24, 30)
    assert connected_parts(free)[0].max() == 1
    assert not free[:, [0, -1]].any()
    assert not free[:, :, [0, -1]].any()
    assert free.any(axis=(1, 2)).all()


@pytest.mark.parametrize("name", NAMES)
def test_a_seed_draws_the_same_building_and_another_seed_another_one(name):
    maps = PRESETS[name].map
    assert maps.floorplan(0, 5).digest == maps.floorplan(0, 5).digest != maps.floorplan(0, 6).digest


@pytest.mark.parametrize("name", NAMES)
def test_teams_start_on_the_largest_part_of_the_level_of_a_flight_at_one_height(name):
    plan = PRESETS[name].map.floorplan(0, 3)
    level, row, col = plan.levels.voxel(plan.start)
    free = np.array(plan.levels.volume(plan.truth)) == FREE
    assert (level, plan.resolution) == (2, 0.5)
    assert largest_part(free[level])[row, col]
    low = PRESETS[name].map.model_copy(update={"start_level": 0}).floorplan(0, 3)
    assert low.levels.voxel(low.start)[0] == 0


def test_wide_cells_are_those_of_squares_of_two_by_two_cells():
    plan = np.array([[1, 1, 0, 0], [1, 1, 1, 1], [0, 0, 0, 1]], bool)
    np.testing.assert_array_equal(wide(plan), [[1, 1, 0, 0], [1, 1, 0, 0], [0, 0, 0, 0]])
    np.testing.assert_array_equal(wide(plan.T), wide(plan).T)


def test_lintels_hang_in_passages_one_cell_wide_and_nowhere_else():
    free = volume_of(BARE, 2)
    hidden = free[0] & ~free[5]
    assert hidden.any()
    np.testing.assert_array_equal(hidden, free[0] & ~wide(free[0]))
    assert free[:4].all(axis=0)[hidden].all()


def test_below_tables_and_between_the_boards_of_shelves_it_is_free():
    bare, full = volume_of(BARE, 4), volume_of(BARE.model_copy(update={"furniture": 0.3}), 4)
    taken = bare & ~full
    assert taken[2].any()
    assert taken[0][taken[2]].all()  # shelves have a board on the floor and on every second level
    assert not taken[1][taken[2]].any()
    assert (taken[1] & ~taken[0]).any()  # below tables
    assert taken[1][taken[0] & ~taken[2]].all()  # below tables that walls and shelves close in
    assert not taken[3:].any()
    floor = (bare[0] & wide(bare[0])).sum()
    assert 0.1 * floor < (taken[0] | taken[1]).sum() < 0.3 * floor + 4 * 4  # the last table may be one too many


def test_hatches_are_single_cells_of_a_slab():
    free = volume_of(TALL.model_copy(update={"hatches": 3}), 1)
    assert free[4].sum() == 3
    assert (free[3] & free[5])[free[4]].all()


def test_stair_wells_and_halls_pass_all_levels_and_storeys_above_surround_halls_with_galleries():
    well = volume_of(TALL.model_copy(update={"wells": 1, "well_size": (3, 3)}), 1)
    assert well.all(axis=0).sum() >= 9
    free = volume_of(TALL.model_copy(update={"halls": 1, "hall_size": (8, 8)}), 1)
    hall = connected_parts(free[4])[0]
    rows, cols = np.nonzero(hall == np.bincount(hall[hall > 0]).argmax())
    assert (np.ptp(rows), np.ptp(cols)) == (7, 7)
    assert free[:, rows, cols].all()
    above = free[5:, max(1, rows.min() - 2) : min(23, rows.max() + 3), max(1, cols.min() - 2) : min(29, cols.max() + 3)]
    assert above.all()


def test_crawl_spaces_lead_through_walls_under_the_ceiling_alone():
    bare, free = volume_of(BARE, 7), volume_of(BARE.model_copy(update={"crawl_spaces": 3}), 7)
    assert (free[:5] == bare[:5]).all()
    assert (free[5] & ~bare[0]).any()  # where the plan has a wall
    assert (free[5] | ~bare[5]).all()


@pytest.mark.parametrize("seed", range(5))
def test_racks_have_boards_uprights_and_gaps_that_are_passed_below_the_highest_level(seed):
    free = volume_of(RacksMaps(**SIZE, goods=0.0), seed)
    racks = ~free[3, 1:-1, 1:-1]
    assert racks.any()
    np.testing.assert_array_equal(~free[7, 1:-1, 1:-1], racks)
    uprights = ~free[0, 1:-1, 1:-1]
    assert (racks | ~uprights).all()
    assert 0 < uprights.sum() < racks.sum() / 3
    assert free[9, 1:-1, 1:-1].all()


def test_goods_stand_on_boards_or_on_the_floor_and_within_racks():
    bare, full = (~volume_of(RacksMaps(**SIZE, goods=share), 2)[:, 1:-1, 1:-1] for share in (0.0, 1.0))
    for floor in (0, 4):
        assert (full[floor] | ~full[floor + 1]).all()
        assert (full[floor + 1] | ~full[floor + 2]).all()
        assert (full[3] | ~full[floor]).all()
        assert bare[floor].sum() / bare[3].sum() < full[floor].sum() / full[3].sum() < 1


@pytest.mark.parametrize(
    ("kind", "settings", "message"),
    [
        (InteriorsMaps, {"hall_size": (70, 80)}, "hall_size begins at 70, more than fits between the walls; lower it"),
        (InteriorsMaps, {"well_size": (3, 2)}, r"well_size is \[3, 2\], expected 1 <= smallest <= largest"),
        (InteriorsMaps, {"headroom": 9}, "headroom is 9, more than storey_height 6; lower it"),
        (InteriorsMaps, {"height": 12, "room_size": (12, 14)}, "height is 12, expected at least 14"),
        (RacksMaps, {"height": 9}, "height is 9, expected at least 11"),
        (RacksMaps, {"aisle": (0, 2)}, r"aisle is \[0, 2\], expected 1 <= smallest <= largest"),
    ],
)
def test_settings_that_cannot_be_built_are_refused(kind, settings, message):
    with pytest.raises(ValidationError, match=message):
        kind(**settings)
