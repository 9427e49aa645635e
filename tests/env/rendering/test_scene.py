"""Pictures of worlds in which sensors or poses err."""

import numpy as np
import pytest

from indoor_explorers.env import FREE, OCCUPIED, UNKNOWN, World, scenario
from indoor_explorers.env.rendering import scene_of
from indoor_explorers.env.rendering.palette import FALSE_FREE, FALSE_OCCUPIED
from tests.env.rendering.scenes import copied, main_map, pixel


@pytest.mark.parametrize("degrees", [60.0, 90.0, 180.0, 300.0, 360.0])
def test_in_view_is_what_the_first_scans_showed(degrees):
    settings = {"radio.model": "none", "lidar.field_of_view": degrees}
    world = World(scenario("small-floors-camera").with_settings(settings), 4)
    world.reset(range(4))
    for episode in range(4):
        assert (scene_of(world, episode).in_view == (world.state.belief[episode] != UNKNOWN)).all()


def test_cells_that_the_team_shows_wrongly_have_colours_of_their_own():
    world = World(scenario("small-floors-errors").with_settings({"drift.rate": 0.2, "drift.closures": 0.0}))
    world.reset([1])
    rng = np.random.default_rng(0)
    for _ in range(60):
        world.step(rng.integers(0, 4, (1, 2)))
    one = scene_of(world, 0)
    nowhere = np.full((1, 2, 2), -99)  # off the map
    picture = main_map(copied(one, trails=nowhere, in_view=one.in_view & False, lidar_range=0.0, radio=("none", 0.0)))
    for shown, true, colour in ((OCCUPIED, FREE, FALSE_OCCUPIED), (FREE, OCCUPIED, FALSE_FREE)):
        wrong = np.argwhere((one.union == shown) & (one.truth == true))
        assert len(wrong)
        for cell in wrong:
            assert tuple(pixel(picture, one.shape, cell)) == colour
