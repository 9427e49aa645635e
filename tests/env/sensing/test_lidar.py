"""Line of sight against an independent geometric reference in rational arithmetic."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.sensing.lidar import scan, view_gain
from tests.env.sensing.reference import ancestor_scan, reference_scan
from tests.marks import slow


@st.composite
def places(draw, side=10):
    """A random map, not square as a rule, and a free cell of it."""
    height, width = draw(st.integers(1, side)), draw(st.integers(1, side))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    truth = np.where(rng.random((height, width)) < draw(st.sampled_from([0.05, 0.2, 0.4])), OCCUPIED, FREE)
    cell = int(rng.integers(height)), int(rng.integers(width))
    truth[cell] = FREE
    return truth.astype(np.uint8), cell


@pytest.mark.parametrize("examples", [250, *slow(1000)])
def test_scan_equals_the_geometric_reference(examples):
    @settings(max_examples=examples, deadline=None)
    @given(places(), st.sampled_from([1.0, 1.5, 2.25, 3.0, 4.5, 8.0]))
    def compare(place, lidar_range):
        truth, cell = place
        np.testing.assert_array_equal(scan(truth, cell, lidar_range), reference_scan(truth, cell, lidar_range))

    compare()


@settings(max_examples=500, deadline=None)
@given(places(side=14), st.sampled_from([2.0, 3.0, 5.5, 9.0]))
def test_free_cells_see_each_other(place, lidar_range):
    truth, cell = place
    for other in np.argwhere(scan(truth, cell, lidar_range) == FREE).tolist():
        assert scan(truth, tuple(other), lidar_range)[cell] == FREE


@pytest.mark.parametrize("lidar_range", [1.0, 3.0, 7.5])
def test_an_open_disc_is_seen_whole(lidar_range):
    truth = np.full((31, 25), FREE)
    rows, cols = np.ogrid[:31, :25]
    disc = (rows - 15) ** 2 + (cols - 12) ** 2 <= lidar_range**2
    np.testing.assert_array_equal(scan(truth, (15, 12), lidar_range) == FREE, disc)


def test_one_touched_corner_does_not_block_and_two_do():
    truth = np.full((2, 2), FREE)
    truth[0, 1] = OCCUPIED
    assert scan(truth, (0, 0), 3.0)[1, 1] == FREE
    truth[1, 0] = OCCUPIED
    assert scan(truth, (0, 0), 3.0)[1, 1] == UNKNOWN


def test_both_walls_of_a_corridor_are_seen_to_the_end():
    truth = np.full((3, 12), OCCUPIED)
    truth[1] = FREE
    belief = scan(truth, (1, 0), 8.0)
    assert (belief[[0, 2], :8] == OCCUPIED).all()
    assert (belief[1, :9] == FREE).all()


@settings(max_examples=60, deadline=None)
@given(places(), st.integers(0, 2**32))
def test_view_gain_counts_what_a_scan_through_unknown_would_show(place, seed):
    truth, cell = place
    hidden = np.random.default_rng(seed).random(truth.shape) < 0.5
    hidden[cell] = False
    belief = np.where(hidden, UNKNOWN, truth).astype(np.uint8)
    transparent = np.where(belief == OCCUPIED, OCCUPIED, FREE).astype(np.uint8)
    seen = reference_scan(transparent, cell, 4.0) == FREE
    assert view_gain(belief, cell, 4.0) == (seen & hidden).sum()


@settings(max_examples=150, deadline=None)
@given(places(side=20), st.sampled_from([1.0, 1.5, 3.0, 4.5, 6.0, 9.0]))
def test_the_ancestors_rays_equal_a_transcription(place, lidar_range):
    truth, cell = place
    found = scan(truth, cell, lidar_range, "marsexplorer")
    np.testing.assert_array_equal(found, ancestor_scan(truth, cell, lidar_range))


def test_the_ancestors_rays_leak_between_obstacles_that_touch_at_a_corner():
    truth = np.full((5, 5), FREE)
    truth[0, 1] = truth[1, 0] = OCCUPIED
    assert scan(truth, (0, 0), 4.0, "marsexplorer")[1, 1] == FREE
    assert scan(truth, (0, 0), 4.0)[1, 1] == UNKNOWN


def test_a_long_range_in_a_cluttered_map_is_exact():
    rng = np.random.default_rng(5)
    truth = np.where(rng.random((30, 47)) < 0.08, OCCUPIED, FREE).astype(np.uint8)
    truth[15, 23] = FREE
    np.testing.assert_array_equal(scan(truth, (15, 23), 25.0), reference_scan(truth, (15, 23), 25.0))
