"""Line of sight against an independent geometric reference in rational arithmetic."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.sensing.lidar import scan, view_gain

DIAGONALS = [
    ((0, 0), (1, 1), (0, 1), (1, 0)),
    ((0, 1), (1, 0), (0, 0), (1, 1)),
]


def overlap(low, high, start, change):
    """Times at which a moving coordinate is strictly between low and high."""
    if change == 0:
        return (Fraction(-1), Fraction(2)) if low < start < high else None
    ends = Fraction(low - start, change), Fraction(high - start, change)
    return min(ends), max(ends)


def crosses(truth, start, end):
    """Whether a segment between two points in half cells runs through an obstacle, or between two at a corner."""
    (y0, x0), (y1, x1) = start, end
    dy, dx = y1 - y0, x1 - x0
    for r, c in np.argwhere(truth == OCCUPIED).tolist():
        rows, cols = overlap(2 * r - 1, 2 * r + 1, y0, dy), overlap(2 * c - 1, 2 * c + 1, x0, dx)
        if rows and cols and max(rows[0], cols[0], 0) < min(rows[1], cols[1], 1):
            return True
    for r, c in np.ndindex(truth.shape[0] - 1, truth.shape[1] - 1):
        y, x = 2 * r + 1, 2 * c + 1
        if (y - y0) * dx != (x - x0) * dy or not min(y0, y1) <= y <= max(y0, y1):
            continue
        if not min(x0, x1) <= x <= max(x0, x1):
            continue
        solid = truth[r : r + 2, c : c + 2] == OCCUPIED
        if any(solid[a] and solid[b] and not solid[p] and not solid[q] for a, b, p, q in DIAGONALS):
            return True
    return False


def reference_scan(truth, cell, lidar_range):
    """The rules of the docstring, one cell at a time."""
    belief = np.full(truth.shape, UNKNOWN)
    row, col = cell
    for r, c in np.ndindex(truth.shape):
        if (r - row) ** 2 + (c - col) ** 2 > Fraction(lidar_range) ** 2:
            continue
        if truth[r, c] == FREE:
            if not crosses(truth, (2 * row, 2 * col), (2 * r, 2 * c)):
                belief[r, c] = FREE
            continue
        for dr, dc in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            inside = 0 <= r + dr < truth.shape[0] and 0 <= c + dc < truth.shape[1]
            if (
                inside
                and truth[r + dr, c + dc] == FREE
                and not crosses(truth, (2 * row, 2 * col), (2 * r + dr, 2 * c + dc))
            ):
                belief[r, c] = OCCUPIED
    return belief


@st.composite
def places(draw, side=10):
    """A random map, not square as a rule, and a free cell of it."""
    height, width = draw(st.integers(1, side)), draw(st.integers(1, side))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    truth = np.where(rng.random((height, width)) < draw(st.sampled_from([0.05, 0.2, 0.4])), OCCUPIED, FREE)
    cell = int(rng.integers(height)), int(rng.integers(width))
    truth[cell] = FREE
    return truth.astype(np.uint8), cell


@settings(max_examples=1000, deadline=None)
@given(places(), st.sampled_from([1.0, 1.5, 2.25, 3.0, 4.5, 8.0]))
def test_scan_equals_the_geometric_reference(place, lidar_range):
    truth, cell = place
    np.testing.assert_array_equal(scan(truth, cell, lidar_range), reference_scan(truth, cell, lidar_range))


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


def ancestor_scan(truth, cell, lidar_range):
    """MarsExplorer's Lidar.update, step by step in numpy: 32 rays of 200 samples, cut half a cell behind a hit."""
    position, angles = np.array(cell), np.linspace(0, 2 * np.pi, 32, endpoint=False)
    heading = np.stack((np.cos(angles), np.sin(angles)), axis=1)

    def cells_along(lengths):
        samples = np.linspace(position, position + np.asarray(lengths).reshape(-1, 1) * heading, 200)
        return np.clip(np.round(samples).astype(int), 0, np.array(truth.shape) - 1)

    lengths = np.full(32, lidar_range)
    for ray, way in enumerate(cells_along(lengths).transpose(1, 0, 2)):
        hits = way[truth[way[:, 0], way[:, 1]] == OCCUPIED]
        if len(hits):
            lengths[ray] = np.linalg.norm(hits - position, axis=1).min()
    seen = cells_along(np.clip(lengths + 0.5, 0, lidar_range)).reshape(-1, 2)
    belief = np.full(truth.shape, UNKNOWN)
    belief[seen[:, 0], seen[:, 1]] = truth[seen[:, 0], seen[:, 1]]
    return belief


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
