"""Line of sight in three dimensions against a reference in rational arithmetic, and against the lidar of plain maps."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.levels import Levels, plane_of
from indoor_explorers.env.sensing.lidar import lidar_model, new_scan, newly_visible_cells, scan, visible_cells
from tests.env.sensing.volume_reference import reference_volume_scan
from tests.marks import slow


def volume_scan(volume, voxel, lidar_range, elevation=90.0):
    """What a scan shows of a volume of several levels."""
    levels, plane = Levels(*volume.shape), plane_of(volume)
    lidar = lidar_model(lidar_range, "exact", len(volume), elevation)
    work = new_scan(lidar)
    count = visible_cells(plane, *levels.cell(voxel), lidar, work)
    seen = work.cells[:count]
    assert len(set(seen.tolist())) == count
    belief = np.full(plane.shape, UNKNOWN)
    belief.flat[seen] = plane.flat[seen]
    assert not belief[levels.between].any()
    return np.array(levels.volume(belief))


@st.composite
def volumes(draw, side=6):
    """A random volume of at least two levels and a free cell of it."""
    shape = draw(st.integers(2, side)), draw(st.integers(1, side)), draw(st.integers(1, side))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    volume = np.where(rng.random(shape) < draw(st.sampled_from([0.05, 0.2, 0.4])), OCCUPIED, FREE).astype(np.uint8)
    voxel = tuple(int(rng.integers(length)) for length in shape)
    volume[voxel] = FREE
    return volume, voxel


@pytest.mark.parametrize("examples", [200, *slow(1500)])
def test_scan_equals_the_rational_reference(examples):
    @settings(max_examples=examples, deadline=None)
    @given(volumes(), st.sampled_from([1.0, 1.5, 1.8, 2.25, 3.0, 4.5, 8.0]))
    def compare(place, lidar_range):
        volume, voxel = place
        found = volume_scan(volume, voxel, lidar_range)
        np.testing.assert_array_equal(found, reference_volume_scan(volume, voxel, lidar_range))

    compare()


@settings(max_examples=100, deadline=None)
@given(volumes(), st.sampled_from([1.5, 3.0, 8.0]), st.integers(0, 2**32))
def test_known_cells_are_left_out_and_nothing_else(place, lidar_range, seed):
    volume, voxel = place
    levels, plane = Levels(*volume.shape), plane_of(volume)
    lidar, cell = lidar_model(lidar_range, "exact", len(volume)), levels.cell(voxel)
    known = np.random.default_rng(seed).integers(0, 3, plane.shape).astype(np.uint8)
    work = new_scan(lidar)
    seen = work.cells[: visible_cells(plane, *cell, lidar, work)].copy()
    left = work.cells[: newly_visible_cells(plane, known, *cell, lidar, work)]
    assert left.tolist() == [seen[0], *(other for other in seen[1:].tolist() if known.flat[other] == 0)]


@settings(max_examples=300, deadline=None)
@given(volumes(side=9), st.sampled_from([2.0, 3.0, 5.5, 9.0]))
def test_free_cells_see_each_other(place, lidar_range):
    volume, voxel = place
    for other in np.argwhere(volume_scan(volume, voxel, lidar_range) == FREE).tolist()[::5]:
        assert volume_scan(volume, tuple(other), lidar_range)[voxel] == FREE


@settings(max_examples=300, deadline=None)
@given(volumes(side=12), st.sampled_from([2.0, 3.0, 5.5, 9.0]))
def test_one_level_is_seen_as_on_a_plain_map(place, lidar_range):
    volume, (level, row, col) = place
    # closed above and below, so that no segment leads over the obstacles of the level
    closed = np.full((3, *volume.shape[1:]), OCCUPIED)
    closed[1] = volume[level]
    found = volume_scan(closed, (1, row, col), lidar_range)
    np.testing.assert_array_equal(found[1], scan(volume[level], (row, col), lidar_range))


@pytest.mark.parametrize("lidar_range", [1.0, 3.0, 4.5])
@pytest.mark.parametrize("elevation", [90.0, 45.0, 15.0])
def test_an_open_ball_is_seen_whole_within_the_elevation(lidar_range, elevation):
    volume = np.full((11, 13, 12), FREE)
    away = np.stack(
        np.meshgrid(*(np.arange(n) - m for n, m in zip((11, 13, 12), (5, 6, 5), strict=True)), indexing="ij")
    )
    flat = np.hypot(away[1], away[2])
    ball = (away**2).sum(axis=0) <= lidar_range**2
    angle = np.degrees(np.arctan2(np.abs(away[0]), flat))
    within = ball & ((angle <= elevation + 1e-6) | (np.abs(away).max(axis=0) <= 1))
    np.testing.assert_array_equal(volume_scan(volume, (5, 6, 5), lidar_range, elevation) == FREE, within)


def test_an_edge_that_two_obstacles_share_blocks_and_one_obstacle_at_it_does_not():
    volume = np.full((2, 1, 2), FREE)
    volume[0, 0, 1] = OCCUPIED
    assert volume_scan(volume, (0, 0, 0), 3.0)[1, 0, 1] == FREE
    volume[1, 0, 0] = OCCUPIED
    assert volume_scan(volume, (0, 0, 0), 3.0)[1, 0, 1] == UNKNOWN


def test_a_corner_is_passed_where_moves_along_the_axes_lead_past_it():
    volume = np.full((2, 2, 2), OCCUPIED)
    volume[0, 0, 0] = volume[1, 1, 1] = volume[1, 0, 0] = FREE
    assert volume_scan(volume, (0, 0, 0), 3.0)[1, 1, 1] == UNKNOWN
    volume[1, 1, 0] = FREE
    assert volume_scan(volume, (0, 0, 0), 3.0)[1, 1, 1] == FREE


def test_a_slab_hides_the_storey_above_but_through_its_opening():
    volume = np.full((3, 9, 9), FREE)
    volume[1] = OCCUPIED
    volume[1, 4, 4] = FREE
    below = volume_scan(volume, (0, 4, 4), 6.0)
    assert below[2, 4, 4] == FREE
    assert below[2, 0, 0] == UNKNOWN
    assert (volume_scan(volume, (0, 0, 0), 6.0)[2] == UNKNOWN).all()


def test_a_lidar_that_covers_too_many_cells_is_refused():
    with pytest.raises(
        InputError, match=r"expected at most 1,000,000 cells around a lidar, got .* shorten lidar.range"
    ):
        lidar_model(200.0, "exact", 20)
