"""Generated buildings of several storeys."""

import numpy as np
import pytest
from pydantic import ValidationError

from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.maps.generators.storeys import StoreysMaps
from indoor_explorers.env.search.connected_parts import connected_parts

SMALL = StoreysMaps(height=24, width=30, room_size=(3, 6), hall_size=(3, 5), corridor=1)


def volume_of(maps, seed):
    plan = maps.floorplan(0, seed)
    assert plan.level_count == maps.level_count
    return np.array(plan.levels.volume(plan.truth)) == FREE


@pytest.mark.parametrize("seed", range(10))
def test_all_free_cells_are_connected_over_six_sides_and_walled_in_on_four(seed):
    free = volume_of(SMALL, seed)
    assert free.shape == (7, 24, 30)
    assert connected_parts(free)[0].max() == 1
    assert not free[:, [0, -1]].any()
    assert not free[:, :, [0, -1]].any()


@pytest.mark.parametrize("seed", range(10))
def test_uavs_get_from_storey_to_storey(seed):
    free = volume_of(SMALL, seed)
    assert free[3].any()
    assert (free[2] & free[3] & free[4]).any()


def test_without_halls_only_the_openings_lead_through_a_slab():
    maps = SMALL.model_copy(update={"halls": 0, "openings": 1, "opening_size": (2, 2)})
    for seed in range(10):
        assert 1 <= volume_of(maps, seed)[3].sum() <= 4


def test_furniture_stands_on_floors_and_leaves_the_upper_half_free():
    bare, full = (SMALL.model_copy(update={"furniture": share}) for share in (0.0, 0.4))
    free = volume_of(bare, 4)
    np.testing.assert_array_equal(free[0], free[2])
    standing = volume_of(full, 4)
    assert standing[2].sum() > standing[1].sum() > standing[0].sum() * 1.02
    assert (standing[1] | ~standing[0]).all()  # nothing hangs in the air


def test_a_seed_draws_the_same_building_and_another_seed_another_one():
    assert SMALL.floorplan(0, 5).digest == SMALL.floorplan(0, 5).digest != SMALL.floorplan(0, 6).digest


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"hall_size": (70, 80)}, "hall_size begins at 70, more than fits between the walls; lower it"),
        ({"opening_size": (3, 2)}, r"opening_size is \[3, 2\], expected 1 <= smallest <= largest"),
        ({"room_size": (70, 80)}, "height is 64, expected at least 72"),
        ({"storeys": 0}, "greater than or equal to 1"),
    ],
)
def test_settings_that_cannot_be_built_are_refused(settings, message):
    with pytest.raises(ValidationError, match=message):
        StoreysMaps(**settings)
