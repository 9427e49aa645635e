"""Readers of MovingAI grids, NumPy arrays, HouseExpo outlines and pictures with a start mark."""

import json
import tracemalloc
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.path import Path as Outline
from PIL import Image

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.maps.files import read_map
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.readers.houseexpo import read_houseexpo
from indoor_explorers.env.maps.readers.image import read_plain
from indoor_explorers.env.maps.readers.movingai import read_movingai
from indoor_explorers.env.maps.readers.npy import occupancy, read_npy
from indoor_explorers.env.maps.readers.opening import read_json
from indoor_explorers.env.maps.sources import FileMaps

SHARED = Path(__file__).parents[4] / ".." / "shared" / "maps"
needs_shared = pytest.mark.skipif(not SHARED.is_dir(), reason="the development maps (../shared/maps) are not here")


def grid(folder, rows, header="type octile\nheight {}\nwidth {}\nmap\n", end="\n"):
    path = folder / "grid.map"
    text = header.format(len(rows), len(rows[0])) + "\n".join(rows) + end
    path.write_bytes(text.encode())
    return path


def test_movingai_ground_and_swamp_are_free(tmp_path):
    cells = read_movingai(grid(tmp_path, [".GS", "@OT", "W.."]))
    assert cells.tolist() == [[FREE] * 3, [OCCUPIED] * 3, [OCCUPIED, FREE, FREE]]


@pytest.mark.parametrize("end", ["", "\n", "\n\n\n"])
@pytest.mark.parametrize(
    "header",
    [
        "type octile\nheight {}\nwidth {}\nmap\n",
        "type octile\r\nheight {}\r\nwidth {}\r\nmap\r\n",
        "height  {} \nwidth {}\nmap\n",
    ],
)
def test_movingai_headers_and_line_ends_as_found_in_the_wild(tmp_path, header, end):
    rows = ["...", ".@."]
    text = (header.format(2, 3) + "\n".join(rows) + end).replace("\n", "\r\n" if "\r" in header else "\n")
    (tmp_path / "a.map").write_bytes(text.replace("\r\r", "\r").encode())
    assert read_movingai(tmp_path / "a.map").tolist() == [[FREE] * 3, [FREE, OCCUPIED, FREE]]


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**32), st.integers(1, 20), st.integers(1, 20))
def test_movingai_round_trip(tmp_path_factory, seed, height, width):
    picked = np.random.default_rng(seed).choice(list(".GS@OTW"), (height, width))
    cells = read_movingai(grid(tmp_path_factory.mktemp("grid"), ["".join(row) for row in picked]))
    assert ((cells == FREE) == np.isin(picked, list(".GS"))).all()
    assert (cells != UNKNOWN).all()


def test_movingai_maps_keep_their_canvas(tmp_path):
    plan = read_map(grid(tmp_path, ["..@.", "..@@", "..@@"]))
    assert plan.truth.tolist() == [[FREE, FREE, OCCUPIED, OCCUPIED]] * 3
    assert (plan.name, plan.resolution, plan.kept, plan.start) == ("grid", 1.0, pytest.approx(6 / 7), None)


@needs_shared
@pytest.mark.parametrize("name", ["16room_000", "32room_000"])
def test_real_movingai_maps_keep_their_rooms(name):
    plan = read_map(SHARED / "movingai" / f"{name}.map")
    assert plan.shape == (512, 512)
    assert plan.kept > 0.99
    assert read_map(SHARED / "movingai" / f"{name}.map", 2.0).kept > 0.9


@pytest.mark.parametrize(
    ("values", "wanted"),
    [
        (np.array([[False, True]]), [FREE, OCCUPIED]),
        (np.array([[0, 1, 255]], np.uint8), [FREE, OCCUPIED, OCCUPIED]),
        (np.array([[0, 1, -1]], np.int8), [FREE, OCCUPIED, UNKNOWN]),
        (np.array([[0, 1, 2, -1]]), [FREE, OCCUPIED, OCCUPIED, UNKNOWN]),
        (np.array([[0, 254, 1, -1]], ">i4"), [FREE, OCCUPIED, OCCUPIED, UNKNOWN]),
        (
            np.array([[0, 19, 20, 65, 66, 100, -1]], np.int8),
            [FREE, FREE, UNKNOWN, UNKNOWN, OCCUPIED, OCCUPIED, UNKNOWN],
        ),
        (np.array([[0.0, 0.19, 0.2, 0.65, 0.66, 1.0, -1.0]]), [1, 1, 0, 0, 2, 2, 0]),
        (np.array([[0.0, 1.0, -1.0]], np.float16), [FREE, OCCUPIED, UNKNOWN]),
    ],
    ids=lambda value: getattr(value, "dtype", None) and f"{value.dtype}-{value.max()}",
)
def test_arrays_are_occupancies(tmp_path, values, wanted):
    np.save(tmp_path / "map.npy", values)
    assert read_npy(tmp_path / "map.npy").tolist() == [wanted]
    assert occupancy(tmp_path, values).dtype == np.uint8


def test_arrays_in_columns_first_order_read_alike(tmp_path):
    values = np.random.default_rng(0).random((7, 11)) < 0.3
    for name, array in (("c", values), ("f", np.asfortranarray(values))):
        np.save(tmp_path / f"{name}.npy", array)
    assert (read_npy(tmp_path / "c.npy") == read_npy(tmp_path / "f.npy")).all()
    assert ((read_npy(tmp_path / "c.npy") == OCCUPIED) == values).all()


def house(folder, verts, **more):
    path = folder / "house.json"
    facts = {"id": "7b", "room_num": 2, "bbox": {"min": [0, 0], "max": [9, 9]}, "verts": verts}
    path.write_text(json.dumps(facts | more))
    return path


#: Two rooms of 4 m x 3 m, a wall of 0.2 m between them, and a door of 0.9 m in it.
TWO_ROOMS = [
    [0, 0],
    [4, 0],
    [4, 1],
    [4.2, 1],
    [4.2, 0],
    [8.2, 0],
    [8.2, 3],
    [4.2, 3],
    [4.2, 1.9],
    [4, 1.9],
    [4, 3],
    [0, 3],
]


def test_a_house_is_free_inside_its_outline(tmp_path):
    plan = read_map(house(tmp_path, TWO_ROOMS))
    assert plan.resolution == 0.1
    assert (plan.truth == FREE).sum() * 0.01 == pytest.approx(2 * 4 * 3 + 0.2 * 0.9, rel=0.05)
    assert plan.kept > 0.95
    wall = (plan.truth[:, 35:50] == OCCUPIED).any(axis=1)
    assert 7 <= (~wall).sum() <= 10
    border = np.ones(plan.shape, np.bool_)
    border[1:-1, 1:-1] = False
    assert (plan.truth[border] == OCCUPIED).all()


@pytest.mark.parametrize(
    ("resolution", "shape"), [(0.05, (62, 166)), (0.2, (17, 43)), (0.33, (11, 27)), (0.4, (9, 22))]
)
def test_a_house_is_drawn_at_the_resolution_asked_for(tmp_path, resolution, shape):
    plan = read_map(house(tmp_path, TWO_ROOMS), resolution)
    assert np.abs(np.array(plan.shape) - shape).max() <= 1
    assert (plan.resolution, plan.kept > 0.9) == (resolution, True)


def test_the_place_of_a_house_and_its_other_keys_do_not_matter(tmp_path):
    digest = read_map(house(tmp_path, TWO_ROOMS)).digest
    moved = [[x - 700.5, y + 1200.25] for x, y in TWO_ROOMS]
    path = house(tmp_path, moved, bbox=None, room_category={"Kitchen": [[0, 0, 1, 1]]})
    assert read_map(path).digest == digest


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.floats(-5, 5), st.floats(-5, 5)), min_size=3, max_size=12))
def test_outlines_enclose_what_matplotlib_says(tmp_path_factory, corners):
    """Pixels away from the outline are free where a ray from them crosses it an odd number of times."""
    corners = np.round(np.array(corners), 3)
    if (np.ptp(corners, axis=0) < 0.5).any():
        return
    path = house(tmp_path_factory.mktemp("house"), corners.tolist())
    cells, metres = read_houseexpo(path, read_json(path), 0.5)
    rows, cols = np.indices(cells.shape).reshape(2, -1)
    places = (np.stack([cols, rows], axis=1) - 10) * metres + corners.min(axis=0)
    crossings = sum(
        ((a[1] > places[:, 1]) != (b[1] > places[:, 1]))
        & (places[:, 0] < (b[0] - a[0]) * (places[:, 1] - a[1]) / np.where(b[1] == a[1], 1, b[1] - a[1]) + a[0])
        for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)
    )
    closed = Outline(np.vstack([corners, corners[:1]]))
    near = np.zeros(len(places), np.bool_)
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        along = np.clip(((places - a) @ (b - a)) / max(float((b - a) @ (b - a)), 1e-12), 0, 1)
        near |= np.hypot(*(places - a - along[:, None] * (b - a)).T) < 2 * metres
    free = cells.ravel() == FREE
    assert (free == (crossings % 2 == 1))[~near].all()
    simple = crossings <= 1
    assert (free == closed.contains_points(places))[~near & simple].all()


@pytest.mark.parametrize("suffix", [".map", ".npy", ".png", ".json"])
def test_the_largest_maps_are_read_and_reduced_in_bounded_memory(tmp_path, suffix):
    """2048 rows of three free to one solid, joined by a column; a house like a comb, drawn nine times finer."""
    solid = np.zeros((2048, 2048), np.bool_)
    solid[::4] = True
    solid[:, 1000] = False
    path = tmp_path / f"large{suffix}"
    if suffix == ".map":
        grid(tmp_path, ["".join(".@"[int(cell)] for cell in row) for row in solid]).rename(path)
    elif suffix == ".npy":
        np.save(path, solid)
    elif suffix == ".png":
        pixels = np.repeat(np.where(solid, 0, 255).astype(np.uint8)[..., None], 3, axis=2)
        pixels[1027, 17] = (255, 0, 0)
        picture(tmp_path, pixels, path.name)
    else:
        teeth = [[x, y] for k in range(100) for x, y in ((2 * k, 1), (2 * k, 199), (2 * k + 1, 199), (2 * k + 1, 1))]
        path.write_text(json.dumps({"verts": [*teeth, [199, 0], [0, 0]]}))
    tracemalloc.start()
    plan = read_map(path)
    coarse = read_map(path, 1.0 if suffix == ".json" else 2.0)
    assert tracemalloc.get_traced_memory()[1] < (800_000_000 if suffix == ".json" else 300_000_000)
    tracemalloc.stop()
    if suffix == ".json":
        assert plan.shape == (1992, 1992)
        return
    assert ((plan.truth == OCCUPIED) == solid).all()
    assert (plan.kept, plan.start) == (1.0, (1027, 17) if suffix == ".png" else None)
    assert coarse.shape == (1024, 1024)
    assert coarse.start == ((513, 8) if suffix == ".png" else None)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["walls.json", "rooms.xml"])
def test_the_largest_buildings_are_drawn_in_bounded_memory(tmp_path, name):
    """A hall of 590 m x 590 m is drawn with nine times the pixels of the largest map."""
    corners = [(0, 0), (590, 0), (590, 590), (0, 590)]
    ends = [{"x": x, "y": y} for x, y in [*corners, (0, 0)]]
    scale = "<scale><{0}><value>1</value><um>m</um></{0}><{1}><value>1</value><um>m</um></{1}></scale>"
    points = "".join(f'<point x="{x}" y="{y}"/>' for x, y in corners)
    text = {
        "walls.json": json.dumps([{"p0": a, "p1": b} for a, b in pairwise(ends)]),
        "rooms.xml": f"<building>{scale.format('represented_distance', 'real_distance')}<floor><spaces><space>"
        f"<bounding_polygon>{points}</bounding_polygon></space></spaces></floor></building>",
    }[name]
    (tmp_path / name).write_text(text)
    tracemalloc.start()
    plan = read_map(tmp_path / name, 0.5)
    assert tracemalloc.get_traced_memory()[1] < 1_000_000_000
    tracemalloc.stop()
    assert plan.shape == pytest.approx((1181, 1181), abs=2)
    assert plan.kept == pytest.approx(1.0, abs=1e-3)


def picture(folder, pixels, name="map.png"):
    Image.fromarray(np.asarray(pixels, np.uint8)).save(folder / name)
    return folder / name


def colours(height=9, width=12):
    """A white room in a black wall."""
    pixels = np.zeros((height, width, 3), np.uint8)
    pixels[1:-1, 1:-1] = 255
    return pixels


@pytest.mark.parametrize("colour", [(255, 0, 0), (0, 200, 0), (0, 0, 255), (255, 216, 0), (180, 20, 20)])
def test_a_coloured_spot_marks_the_start_and_is_free(tmp_path, colour):
    pixels = colours()
    pixels[3:6, 4:7] = colour
    plan = read_map(picture(tmp_path, pixels))
    assert plan.start == (4, 5)
    assert (plan.truth == FREE).sum() == 7 * 10


def test_a_single_pixel_is_mark_enough(tmp_path):
    pixels = colours()
    pixels[2, 3] = (255, 0, 0)
    assert read_plain(picture(tmp_path, pixels))[1] == (2, 3)
    assert read_plain(picture(tmp_path, [[[255, 0, 0], [255, 255, 255]]]))[1] == (0, 0)


def test_a_start_makes_another_task_of_the_same_cells(tmp_path):
    pixels = colours()
    plain = read_map(picture(tmp_path, pixels))
    assert plain.digest == Floorplan(plain.truth, "another").digest
    digests, fingerprints = {plain.digest}, set()
    for place in ((2, 3), (2, 4)):
        marked = pixels.copy()
        marked[place] = (255, 0, 0)
        path = picture(tmp_path, marked, f"{place}.png")
        plan = read_map(path)
        assert (plan.truth == plain.truth).all()
        digests.add(plan.digest)
        fingerprints.add(Scenario(map=FileMaps(paths=(str(path),))).fingerprint)
    assert len(digests) == 3
    assert len(fingerprints) == 2


@pytest.mark.parametrize(
    ("places", "why"),
    [
        ([np.s_[2, 3], np.s_[2, 6]], "two spots are a drawing"),
        ([np.s_[1:4, 1:8]], "a large spot is a carpet"),
        ([], "no colour at all"),
    ],
)
def test_other_colours_are_no_mark(tmp_path, places, why):
    pixels = colours()
    for place in places:
        pixels[place] = (255, 216, 0)
    assert read_plain(picture(tmp_path, pixels))[1] is None, why


def test_pale_colours_are_no_mark(tmp_path):
    pixels = colours()
    pixels[2, 3] = (255, 200, 200)
    assert read_plain(picture(tmp_path, pixels))[1] is None


@pytest.mark.parametrize("level", [203, 208])
def test_grey_levels_of_the_dungeons_mark_the_start(tmp_path, level):
    pixels = np.full((40, 60), 127)
    pixels[5:30, 5:50] = 194
    pixels[8:12, 20:24] = level
    assert read_map(picture(tmp_path, pixels)).start == (9, 21)
    pixels[20, 6:14] = [10, 20, 30, 40, 50, 60, 70, 80]
    assert read_map(picture(tmp_path, pixels)).start is None, "a scan has many levels"


def test_a_start_in_a_room_that_cannot_be_reached_moves_to_the_main_part(tmp_path):
    pixels = colours()
    pixels[:, 8] = 0
    pixels[4, 9] = (0, 255, 0)
    assert read_map(picture(tmp_path, pixels)).start == (4, 7)


def test_a_floor_plan_refuses_a_start_in_a_wall_or_outside():
    truth = np.array([[FREE, OCCUPIED]], np.uint8)
    assert Floorplan(truth, "ok", start=(0, 0)).start == (0, 0)
    for start in ((0, 1), (0, 2), (-1, 0)):
        with pytest.raises(InputError, match="expected the start on a free cell"):
            Floorplan(truth, "bad", start=start)


@needs_shared
@pytest.mark.parametrize(("resolution", "every"), [(None, 8), (4.0, 5), pytest.param(4.0, 1, marks=pytest.mark.slow)])
def test_every_dungeon_has_its_start_in_colour_and_in_grey(tmp_path, resolution, every):
    files = sorted((SHARED / "dungeon").glob("*.png"))
    assert len(files) == 40
    for path in files[::every]:
        with Image.open(path) as image:
            pixels = np.asarray(image.convert("RGB")).astype(int)
        spot = np.argwhere((pixels == (255, 216, 0)).all(axis=2))
        plan = read_map(path, resolution)
        assert plan.start is not None
        low, high = spot.min(axis=0) // (resolution or 1), spot.max(axis=0) // (resolution or 1)
        assert (low <= plan.start).all()
        assert (plan.start <= high).all()
        for weights in ((0.299, 0.587, 0.114), (0.2125, 0.7154, 0.0721)):  # Pillow's grey, and scikit-image's
            grey = read_map(picture(tmp_path, (pixels @ weights).astype(np.uint8)), resolution)
            assert (grey.start, grey.digest) == (plan.start, plan.digest)
