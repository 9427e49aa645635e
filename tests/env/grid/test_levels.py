"""Volumes and their planes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from indoor_explorers.env.grid.cells import MOVES, OCCUPIED, Action
from indoor_explorers.env.grid.levels import ASCEND, DESCEND, Levels, action_between, plane_of, target_of

SIZES = st.tuples(st.integers(1, 6), st.integers(1, 7), st.integers(1, 7))


@given(SIZES, st.integers(0, 2**32))
def test_a_volume_is_found_again_in_its_plane(size, seed):
    volume = np.random.default_rng(seed).integers(0, 3, size, dtype=np.uint8)
    levels, plane = Levels(*size), plane_of(volume)
    assert plane.shape == levels.shape
    assert Levels.of(plane.shape, levels.number) == levels
    np.testing.assert_array_equal(levels.volume(plane), volume)
    assert (plane[levels.between] == OCCUPIED).all()
    assert levels.between.sum() == (size[0] - 1) * size[2]
    for voxel in np.ndindex(size):
        assert plane[levels.cell(voxel)] == volume[voxel]
        assert levels.voxel(levels.cell(voxel)) == voxel


@given(SIZES)
def test_actions_lead_to_neighbours_in_the_volume(size):
    levels = Levels(*size)
    ways = {action: (0, *MOVES[action].tolist()) for action in Action if action != Action.STAY}
    ways |= {ASCEND: (1, 0, 0), DESCEND: (-1, 0, 0)} if levels.number > 1 else {}
    for voxel in np.ndindex(size):
        for action, way in ways.items():
            beside = tuple(int(a + b) for a, b in zip(voxel, way, strict=True))
            if all(0 <= place < length for place, length in zip(beside, size, strict=True)):
                target = target_of(levels.cell(voxel), action, levels.rise)
                assert levels.voxel(target) == beside
                assert action_between(levels.cell(voxel), target, levels.rise) == action


def test_one_level_is_its_own_plane():
    levels = Levels(1, 4, 5)
    assert (levels.shape, levels.rise, levels.moves) == ((4, 5), 0, 5)
    plane = np.arange(20).reshape(4, 5)
    np.testing.assert_array_equal(levels.volume(plane)[0], plane)


@pytest.mark.parametrize(("rows", "count"), [(7, 3), (5, 0), (2, 3)])
def test_planes_of_other_sizes_are_refused(rows, count):
    with pytest.raises(ValueError, match=f"expected a plane of {count} levels of equal height, got {rows} rows"):
        Levels.of((rows, 4), count)
