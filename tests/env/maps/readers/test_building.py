"""The reader of rooms and portals: what it draws, pixel by pixel."""

import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.maps.files import read_map
from indoor_explorers.env.maps.readers.building import parse_building, read_building

FLOORS = Path(__file__).parents[4] / ".." / "shared" / "maps" / "floors"
#: The folder python/blocked_sampling/dataset of a checkout of github.com/goldleaf3i/generativeCMLgraphs.
#: The share of free area that is kept: the free pixels around a building are not.
KEPT = pytest.approx(0.95, abs=0.01)
CML = Path(os.environ.get("CML_DATASET", "no-folder"))

DRAWING = """<?xml version="1.0" encoding="UTF-8"?>
<building id="b">
  <name>made for this test</name>
  <scale>
    <represented_distance><value>{pixels}</value><um>pixel</um></represented_distance>
    <real_distance><value>{real}</value><um>{unit}</um></real_distance>
  </scale>
  <floor>
    <spaces>{spaces}</spaces>
    <groups><group_features><space>a</space></group_features></groups>
  </floor>
</building>
"""


def points(places):
    return "".join(f'<point x="{x}" y="{y}"/>' for x, y in places)


def room(corners, *doors, kind="PORTAL"):
    """A space with its corners, and doors, points or pairs of points."""
    pairs = [door if isinstance(door[0], tuple) else (door, door) for door in doors]
    segments = "".join(f"<linesegment>{points(pair)}<class>{kind}</class></linesegment>" for pair in pairs)
    return (
        f"<space><centroid>{points([(0, 0)])}</centroid><bounding_polygon>{points(corners)}</bounding_polygon>"
        f"<space_representation>{segments}</space_representation></space>"
    )


def written(folder, *rooms, pixels=20, real=200, unit="cm"):
    path = folder / "rooms.xml"
    path.write_text(DRAWING.format(spaces="".join(rooms), pixels=pixels, real=real, unit=unit))
    return path


def box(left, top, right, bottom):
    return [(left, top), (right, top), (right, bottom), (left, bottom)]


#: Two rooms of 3 m x 4 m side by side, where ten units are a metre, and the middle of the wall between them.
LEFT, RIGHT, MIDDLE = box(0, 0, 30, 40), box(30, 0, 60, 40), (30, 20)


def test_rooms_are_drawn_exactly(tmp_path):
    """Two pixels of wall along the outline, free inside and a pixel around, unknown outside, and a margin of 1 m."""
    wanted = np.full((40 + 20, 60 + 20), UNKNOWN)
    wanted[9:52, 10:71] = FREE
    wanted[10:51, 9:72] = OCCUPIED
    wanted[12:49, 11:39] = wanted[12:49, 42:70] = FREE
    cells, metres = read_building(written(tmp_path, room(LEFT), room(RIGHT)))
    assert metres == 0.1
    assert (cells == wanted).all()


@pytest.mark.parametrize("door", [MIDDLE, ((30, 20), (30, 20)), ((30, 18), (30, 22))])
def test_doors_are_opened_nine_tenths_of_a_metre(tmp_path, door):
    """Of all walls of the two rooms that meet there; ten pixels are touched."""
    cells, _ = read_building(written(tmp_path, room(LEFT, door), room(RIGHT, door)))
    closed, _ = read_building(written(tmp_path, room(LEFT), room(RIGHT)))
    opened = np.argwhere(cells != closed)
    assert (cells[cells != closed] == FREE).all()
    assert (opened.min(axis=0).tolist(), opened.max(axis=0).tolist()) == ([25, 39], [34, 41])


def test_only_portals_are_doors(tmp_path):
    assert read_map(written(tmp_path, room(LEFT, MIDDLE), room(RIGHT))).kept == KEPT
    for closed in ([room(LEFT), room(RIGHT)], [room(LEFT, MIDDLE, kind="WALL"), room(RIGHT)]):
        assert read_map(written(tmp_path, *closed)).kept == pytest.approx(0.5, abs=0.05)


def test_a_door_beyond_the_sheet_opens_nothing(tmp_path):
    wanted, _ = read_building(written(tmp_path, room(LEFT)))
    cells, _ = read_building(written(tmp_path, room(LEFT, (1e9, -1e9), (500, 20))))
    assert (cells == wanted).all()


def test_a_doorway_between_two_outlines_is_opened(tmp_path):
    """The wall between the rooms is 0.4 m thick, and only its faces have portals."""
    apart = [(x + 4, y) for x, y in RIGHT]
    cells, _ = read_building(written(tmp_path, room(LEFT, (30, 20)), room(apart, (34, 20))))
    assert cells[30, 42] == UNKNOWN
    plan = read_map(written(tmp_path, room(LEFT, (30, 20)), room(apart, (34, 20))))
    assert plan.kept == KEPT
    assert plan.shape[1] > 60


@pytest.mark.parametrize(
    ("pixels", "real", "unit"),
    [(20, 200, "cm"), (1, 0.1, "m"), (10, 1000, "mm"), (10.0, 100, "cm")],
)
def test_the_scale_says_how_large_the_building_is(tmp_path, pixels, real, unit):
    building = parse_building(written(tmp_path, room(LEFT, MIDDLE), pixels=pixels, real=real, unit=unit))
    assert building.outlines[0].max(axis=0) == pytest.approx([3.0, 4.0])
    assert building.portals == pytest.approx(np.array([[3.0, 2.0]]))
    larger, _ = read_building(written(tmp_path, room(LEFT, MIDDLE), pixels=pixels, real=real * 2, unit=unit))
    assert larger.shape == (80 + 20, 60 + 20)


@pytest.mark.parametrize("offset", [(0, 0), (-317, 4500), (12345, -20)])
@pytest.mark.parametrize("resolution", [None, 0.25, 0.5])
def test_the_place_of_a_building_does_not_matter(tmp_path, offset, resolution):
    plan = read_map(written(tmp_path, room(LEFT, MIDDLE), room(RIGHT)), resolution)
    moved = [[(x + offset[0], y + offset[1]) for x, y in shape] for shape in (LEFT, RIGHT, [MIDDLE])]
    other = read_map(written(tmp_path, room(moved[0], *moved[2]), room(moved[1])), resolution)
    assert plan.shape == other.shape
    assert (plan.truth != other.truth).mean() < 0.03
    assert (plan.resolution, plan.kept) == (resolution or 0.1, KEPT)
    assert 0.55 < (plan.truth == FREE).sum() * plan.resolution**2 / (2 * 3 * 4) < 1.0


def test_rooms_need_no_right_angles_and_empty_spaces_are_left_out(tmp_path):
    slanted = room([(0, 0), (60, 20), (40, 80), (-20, 60)])
    cells, _ = read_building(written(tmp_path, room([]), slanted))
    wanted, _ = read_building(written(tmp_path, slanted))
    assert (cells == wanted).all()
    assert (cells == FREE).sum() * 0.01 == pytest.approx(40, rel=0.07)
    assert cells[0, 0] == UNKNOWN
    assert cells[50, 50] == FREE


@pytest.mark.skipif(not CML.is_dir(), reason="CML_DATASET names no dataset of goldleaf3i/generativeCMLgraphs")
@pytest.mark.skipif(not FLOORS.is_dir(), reason="the development maps (../shared/maps/floors) are not here")
def test_real_floors_are_drawn_as_they_were_before():
    """The pictures count the offices by name from 00 on, then the schools."""
    sources = [path for kind in ("OFFICE", "SCHOOL") for path in sorted((CML / kind).glob("*.xml"))]
    files = sorted(FLOORS.glob("cml_*.png"))
    assert len(files) == 43
    for file in files:
        path = sources[int(file.stem.rpartition("_")[2])]
        cells, _ = read_building(path)
        with Image.open(file) as picture:
            before = np.select([np.asarray(picture) == 254, np.asarray(picture) == 0], [FREE, OCCUPIED], UNKNOWN)
        assert (cells == before).all()
        assert read_map(path, 0.5).digest == read_map(file.with_suffix(".yaml"), 0.5).digest
