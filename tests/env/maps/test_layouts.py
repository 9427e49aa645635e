"""Layouts: what is the same map up to symmetry, border and scale, and how far two maps overlap."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from indoor_explorers.env import scenario
from indoor_explorers.env.maps.layouts import layout_digest, mask_digest, overlap, symmetries
from indoor_explorers.env.simulation.spawns import draw_floorplan

MASKS = arrays(bool, array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=9)).filter(np.any)
#: An L of free cells in a corner of walls: no symmetry maps it to itself.
CORNER = np.array([[0, 0, 0, 0], [0, 1, 0, 0], [0, 1, 0, 0], [0, 1, 1, 0]], bool)


@given(MASKS, st.integers(0, 7), st.integers(1, 3), st.integers(0, 3))
def test_a_layout_is_the_same_turned_mirrored_rescaled_and_framed(free, symmetry, scale, border):
    changed = list(symmetries(free))[symmetry].repeat(scale, axis=0).repeat(scale, axis=1)
    assert layout_digest(np.pad(changed, border)) == layout_digest(free)
    assert overlap(free, np.pad(changed, border)) == 1.0


@given(arrays(bool, (5, 7)).filter(np.any), st.integers(0, 34))
def test_another_cell_is_another_layout(free, number):
    other = free.copy()
    other.flat[number] ^= True
    framed = [np.pad(cells, 2, constant_values=True) for cells in (free, other)]  # whose corners crop and scale nothing
    assert layout_digest(framed[0]) != layout_digest(framed[1])


@pytest.mark.parametrize("change", [np.rot90, np.fliplr, np.flipud, np.transpose])
def test_the_digest_of_cells_tells_symmetric_maps_apart_and_that_of_all_symmetries_does_not(
    change: Callable[[np.ndarray], np.ndarray],
):
    assert mask_digest([CORNER]) != mask_digest([change(CORNER)])
    assert mask_digest(symmetries(CORNER)) == mask_digest(symmetries(change(CORNER)))
    assert mask_digest(symmetries(CORNER)) != mask_digest(symmetries(np.pad(CORNER, 1)))


def test_overlap_is_the_shared_share_of_the_free_cells():
    room = np.ones((10, 10), bool)
    half = room.copy()
    half[0, :5] = False
    assert overlap(room, half) == pytest.approx(0.95)
    assert overlap(half, np.rot90(half, 3)) == 1.0
    assert overlap(CORNER, np.ones((3, 2), bool)) == pytest.approx(4 / 6)


def test_floor_plans_have_layouts():
    first, second = (draw_floorplan(scenario("floors"), seed, 0) for seed in (1, 2))
    assert first.layout == layout_digest(first.truth == 1) != second.layout
