"""Kinds of floor plans: exact statistics on floors drawn by hand, and the generators' maps by their kind."""

import numpy as np
import pytest

from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.kinds import Kind, kind_of, statistics_of
from indoor_explorers.env.maps.sources import CaveMaps, FloorsMaps, MazeMaps, OfficesMaps, RoomsMaps, ThesisMaps, office


def plan(free, resolution=None):
    return Floorplan.from_free(np.pad(free, 1), "drawn", resolution)


def hall():
    return np.ones((20, 30), np.bool_)


def columned():
    free = hall()
    free[4:17:4, 4:27:4] = False
    return free


def racks():
    free = np.ones((44, 60), np.bool_)
    for row in (10, 22, 34):
        free[row : row + 3, 8:52] = False
    return free


def along_a_corridor():
    free = np.zeros((17, 47), np.bool_)
    free[7:10] = True
    for col in range(0, 48, 8):
        free[:6, col : col + 7] = free[11:, col : col + 7] = True
        free[6:11, col + 3] = True
    return free


def comb():
    free = np.zeros((23, 47), np.bool_)
    free[:3] = True
    for col in range(0, 47, 4):
        free[:, col : col + 3] = True
    return free


def without_doors():
    free = np.zeros((60, 90), np.bool_)
    free[:20, :20] = free[35:60, 60:90] = free[40:58, 10:30] = True
    free[6:14, 20:70] = free[6:40, 66:74] = free[44:52, 28:70] = True
    return free


DRAWN = [
    (hall, Kind.HALL),
    (columned, Kind.HALL),
    (racks, Kind.HALL),
    (along_a_corridor, Kind.ROOMS),
    (comb, Kind.MAZE),
    (without_doors, Kind.DUNGEON),
]


@pytest.mark.parametrize(("drawn", "kind"), DRAWN)
@pytest.mark.parametrize("turns", [0, 1])
def test_drawn_floors_have_their_kind(drawn, kind, turns):
    assert kind_of(plan(np.rot90(drawn(), turns))) is kind


def test_statistics_of_an_empty_hall():
    found = statistics_of(plan(np.ones((4, 6), np.bool_)))
    assert (found.view, found.rooms, found.solidity, found.straight) == (1.0, 1.0, 1.0, 1.0 - 8 / 20)
    assert found.openness == 24 / 317  # all of it, of the cells of a disc of 10 cells
    assert found.clearance == pytest.approx((16 * 1 + 8 * 2) / 24)


def test_statistics_of_rooms_along_a_corridor():
    found = statistics_of(plan(along_a_corridor()))
    sizes = np.array([6 * 7] * 12 + [3 * 47 + 12])  # doors are parts of the corridor, which is as narrow
    assert found.rooms == pytest.approx(sizes.sum() ** 2 / (sizes**2).sum())
    assert found.corridors == pytest.approx((3 * 47 + 12) / sizes.sum())
    assert found.view < 0.25 < found.solidity


def test_clearance_is_in_metres_only_where_a_pixel_is_none():
    free = np.ones((1, 9), np.bool_)
    assert statistics_of(plan(free, 0.5)).clearance == 0.5
    assert statistics_of(plan(free)).clearance == statistics_of(plan(free, 4.0)).clearance == 1.0


def test_a_finer_grid_changes_no_kind():
    for drawn, kind in DRAWN:
        fine = np.repeat(np.repeat(drawn(), 2, axis=0), 2, axis=1)
        assert kind_of(plan(drawn(), 0.5)) is kind_of(plan(fine, 0.25)) is kind


def test_what_is_around_a_floor_changes_nothing():
    drawn = along_a_corridor()
    wide = Floorplan.from_free(np.pad(drawn, ((3, 40), (9, 2))), "drawn")
    assert statistics_of(wide) == statistics_of(plan(drawn))


@pytest.mark.parametrize(
    ("maps", "kind"),
    [
        (FloorsMaps(), Kind.ROOMS),
        (OfficesMaps(), Kind.ROOMS),
        (RoomsMaps(), Kind.ROOMS),
        (ThesisMaps(), Kind.HALL),
        (MazeMaps(), Kind.MAZE),
        (CaveMaps(), Kind.DUNGEON),
    ],
)
def test_nine_of_ten_generated_maps_have_their_kind(maps, kind):
    seeds = range(1000, 1020)  # none of those that the thresholds were chosen on
    assert sum(kind_of(maps.floorplan(0, seed)) is kind for seed in seeds) >= 18


def test_the_office_is_one_of_rooms():
    assert kind_of(office()) is Kind.ROOMS


def test_a_single_cell_has_statistics():
    found = statistics_of(plan(np.ones((1, 1), np.bool_)))
    assert (found.view, found.rooms, found.solidity) == (1.0, 1.0, 1.0)
