"""The thesis's image (its Table 3.1), with and without identity, and the window on other maps."""

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, World
from indoor_explorers.env.observations.planes import ThesisImage
from indoor_explorers.learners.thesis.observation import LEVELS, paint_all, painted, window


@pytest.fixture(scope="module")
def world():
    """Four UAVs of which some have met."""
    world = World(PRESETS["thesis-team-4-radio-3"].with_settings({"on_collision": "block", "stuck.rule": "off"}), 3)
    world.reset([1, 2, 3])
    rng = np.random.default_rng(1)
    for _ in range(40):
        world.step(rng.integers(0, 4, (3, 4)))
    assert any(len(world.view(b, n).mates) > 1 for b in range(3) for n in range(4))
    return world


def everyone(world):
    return [(b, n, world.view(b, n)) for b in range(3) for n in range(4)]


def test_the_image_is_that_of_the_environments(world):
    for b, n, view in everyone(world):
        expected = ThesisImage()(world.briefing(b, n)).observation(view)
        assert np.array_equal(LEVELS[painted(view, n, identity=False)], expected)


def test_with_identity_a_uav_sees_itself_as_one_and_every_mate_as_two(world):
    for _, n, view in everyone(world):
        image = LEVELS[painted(view, n, identity=True)]
        assert image[view.cell] == 1.0
        mates = {mate.cell for mate in view.mates} - {view.cell}
        assert {tuple(cell) for cell in np.argwhere(image == 2.0).tolist()} == mates
        assert image.max() <= 2.0


def test_linked_uavs_see_the_same_image_unless_they_know_who_they_are():
    world = World(PRESETS["thesis-team-2-radio-3"])
    world.begin(0, 1, spawns=[(4, 4), (5, 5)])
    first, second = world.view(0, 0), world.view(0, 1)
    assert np.array_equal(painted(first, 0, identity=False), painted(second, 1, identity=False))
    assert not np.array_equal(painted(first, 0, identity=True), painted(second, 1, identity=True))


@pytest.mark.parametrize("identity", [False, True])
def test_a_batch_is_painted_as_one_view_is(world, identity):
    state, columns = world.state, np.array([0, 3, 6, 11])
    images = np.full((12, 16, 16), 99, np.uint8)
    paint_all(
        state.belief, state.cell, state.last_received_step, state.last_received_cell, identity, columns, 4, images
    )
    for column in range(12):
        b, n = divmod(column, 4)
        alone = painted(world.view(b, n), n, identity=identity)
        assert np.array_equal(images[column], alone) if column in columns else (images[column] == 99).all()


def test_numbers_that_no_byte_holds_share_the_last_code(world):
    view = world.view(0, 0)
    assert painted(view, 255, identity=False)[view.cell] == 255


def test_the_window_is_the_whole_map_where_it_fits():
    image = np.arange(256, dtype=np.uint8).reshape(16, 16)
    out = np.empty((1, 16, 16), np.uint8)
    window([image], (3, 9), (16, 16), out)
    assert np.array_equal(out[0], image)


def test_on_a_larger_map_the_window_holds_the_cell_and_stays_inside():
    image = np.random.default_rng(1).integers(0, 200, (40, 20), dtype=np.uint8)
    out = np.empty((1, 16, 16), np.uint8)
    for cell, top, left in (((0, 0), 0, 0), ((20, 10), 12, 2), ((39, 19), 24, 4)):
        window([image], cell, (16, 16), out)
        assert np.array_equal(out[0], image[top : top + 16, left : left + 16])


def test_a_smaller_map_has_obstacles_around_it():
    out = np.empty((2, 16, 16), np.uint8)
    window([np.zeros((8, 10), np.uint8)] * 2, (2, 2), (16, 16), out)
    assert (out[:, 4:12, 3:13] == 0).all()
    assert (out == 2).sum() == 2 * (256 - 80)
