"""The reader of wall segments: what it draws, pixel by pixel."""

import json
import os
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from scipy import ndimage

from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.maps.files import read_map
from indoor_explorers.env.maps.readers.opening import read_json
from indoor_explorers.env.maps.readers.sheet import within
from indoor_explorers.env.maps.readers.vectormap import read_vectormap

FLOORS = Path(__file__).parents[4] / ".." / "shared" / "maps" / "floors"
#: A checkout of github.com/ut-amrl/amrl_maps.
AMRL = Path(os.environ.get("AMRL_MAPS", "no-folder"))


def written(folder, *paths, name="walls.json"):
    """Write walls along paths of corners (x, y)."""
    ends = [(a, b) for path in paths for a, b in pairwise(path)]
    data = [{f"p{k}": {"x": float(x), "y": float(y)} for k, (x, y) in enumerate(pair)} for pair in ends]
    (folder / name).write_text(json.dumps(data))
    return folder / name


def drawn(path):
    cells, metres = read_vectormap(path, read_json(path))
    assert metres == 0.1
    return cells


#: The facade of 6 m x 5 m.
FACADE = [(0, 0), (6, 0), (6, 5), (0, 5), (0, 0)]


def test_a_closed_facade_is_drawn_exactly(tmp_path):
    """Two pixels of wall, free inside, unknown outside, and a margin of 2 m."""
    wanted = np.full((50 + 40, 60 + 40), UNKNOWN)
    wanted[19:72, 20:81] = OCCUPIED
    wanted[21:70, 22:79] = FREE
    assert (drawn(written(tmp_path, FACADE)) == wanted).all()


def test_y_points_up_and_x_to_the_right(tmp_path):
    cells = drawn(written(tmp_path, FACADE, [(4, 4), (5, 4)]))
    rows, cols = np.nonzero(cells[25:65, 25:75] == OCCUPIED)
    assert rows.mean() + 25 == pytest.approx(20 + 10, abs=1)
    assert cols.mean() + 25 == pytest.approx(20 + 45, abs=1)


@pytest.mark.parametrize("offset", [(0, 0), (-37.5, 12.25), (5000.0, -8192.0)])
@pytest.mark.parametrize("resolution", [None, 0.25, 0.5])
def test_the_place_of_a_building_does_not_matter(tmp_path, offset, resolution):
    paths = [FACADE, [(3, 0), (3, 2)], [(3, 3), (3, 5)]]
    moved = [[(x + offset[0], y + offset[1]) for x, y in path] for path in paths]
    plan, other = (read_map(written(tmp_path, *some), resolution) for some in (paths, moved))
    assert plan.shape == other.shape
    assert (plan.truth != other.truth).mean() < 0.02
    assert plan.resolution == (resolution or 0.1)
    assert plan.kept == pytest.approx(1.0)
    assert 0.55 < (plan.truth == FREE).sum() * plan.resolution**2 / (6 * 5) < 1.0


@pytest.mark.parametrize(("gap", "closed"), [(0.5, True), (1.2, True), (1.5, True), (2.0, False), (3.0, False)])
def test_a_gap_in_the_facade_is_closed_up_to_one_and_a_half_metres(tmp_path, gap, closed):
    cells = drawn(written(tmp_path, [(3 - gap / 2, 0), (0, 0), (0, 5), (6, 5), (6, 0), (3 + gap / 2, 0)]))
    assert (cells[25:60, 25:75] == (FREE if closed else UNKNOWN)).all()
    assert (cells[0] == UNKNOWN).all()


def test_a_door_inside_stays_open_and_a_closed_room_is_left_out(tmp_path):
    plan = read_map(written(tmp_path, FACADE, [(3, 0), (3, 2)], [(3, 3), (3, 5)]))
    assert plan.kept == 1.0
    closed = read_map(written(tmp_path, FACADE, [(4, 0), (4, 5)]))
    assert closed.kept == pytest.approx(2 / 3, abs=0.03)
    assert closed.shape == pytest.approx((50, 40), abs=2)


@settings(max_examples=200, deadline=None)
@given(st.integers(0, 9), st.integers(0, 2**32), st.floats(0.0, 0.3), st.integers(1, 40), st.integers(1, 40))
def test_within_is_the_euclidean_distance(radius, seed, share, height, width):
    mask = np.random.default_rng(seed).random((height, width)) < share
    far = np.inf if not mask.any() else ndimage.distance_transform_edt(~mask)
    assert (within(mask, radius) == (far <= radius)).all()


@pytest.mark.skipif(not AMRL.is_dir(), reason="AMRL_MAPS names no checkout of ut-amrl/amrl_maps")
@pytest.mark.skipif(not FLOORS.is_dir(), reason="the development maps (../shared/maps/floors) are not here")
def test_real_floors_are_drawn_as_they_were_before():
    files = sorted(FLOORS.glob("amrl_*.png"))
    assert len(files) == 7
    for file in files:
        name = file.stem.removeprefix("amrl_")
        path = AMRL / name / f"{name}.vectormap.json"
        with Image.open(file) as picture:
            assert (np.array([205, 254, 0])[drawn(path)] == np.asarray(picture)).all()
        assert read_map(path, 0.5).digest == read_map(file.with_suffix(".yaml"), 0.5).digest
