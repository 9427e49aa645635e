"""Broken and hostile map files: one clear line each, in no time and little memory."""

import io
import json
import os
import struct
import tracemalloc
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from indoor_explorers.env import InputError
from indoor_explorers.env.maps.files import READERS, read_map
from tests.env.maps.test_bad_files import refusal as refused
from tests.marks import slow

#: What refusing a file may allocate, whatever its header promises.
LITTLE = 200_000_000


def refusal(folder, name, data):
    """Return the message that a file is refused with: one line that names the file."""
    path = folder / name
    path.write_bytes(data)
    tracemalloc.start()
    message = refused(path)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < LITTLE
    return message


def grid(height, width, body="", kind="octile"):
    return f"type {kind}\nheight {height}\nwidth {width}\nmap\n{body}".encode()


# fmt: off
GRIDS = [
    (b"", "expected the lines 'type octile'"),
    (b"\x00" * 5000, "is it a MovingAI map?"),
    (b"height 3\n" * 100_000, "no line 'map' in the first 1000 bytes"),
    (b"map\n...\n", "expected a line 'height N' before the line 'map', got none; add it"),
    (b"type octile\nheight 1\nmap\n.\n", "expected a line 'width N'"),
    (grid(1, 1, ".", kind="hex"), "expected type octile, got 'hex'"),
    (grid(10**9, 10**9), "height: expected a whole number from 1 to 999999999"),
    (grid(10**8, 10**8), "expected at most 36,000,000 cells, got 100,000,000 x 100,000,000"),
    (grid("9" * 800, 3), "height: expected a whole number"),
    (grid(-3, 3), "got '-3'"),
    (grid(3, 0), "width: expected a whole number from 1"),
    (grid("3.0", 3), "got '3.0'"),
    (grid("٣", 3, "...\n" * 3), "height: expected a whole number"),
    (grid(30_000_000, 1, "\n" * 5_000_000), "expected 1 characters in row 1, got 0"),
    (grid(3, 3, "\n" * 5_000_000), "expected 3 rows of 3 characters, got far more"),
    (grid(3, 3, "...\n...\n"), "expected 3 rows of 3 characters, got 2; correct the header or the map"),
    (grid(3, 3, "...\n" * 4), "expected 3 rows of 3 characters, got 4"),
    (grid(3, 3, "...\n....\n...\n"), "expected 3 characters in row 2, got 4"),
    (grid(3, 3, "...\n..\n....\n"), "expected 3 characters in row 2, got 2"),
    (grid(2, 3, "...\n.x.\n"), ".GS (free) and @OTW (solid), got 'x' in row 2, column 2"),
    (grid(2, 3, "...\n.\n.\n"), "expected 3 characters in row 2, got 1"),
    (grid(1, 3, "@@@\n"), "expected a map with free pixels, got none"),
]
# fmt: on


def array(shape, descr="<f8", data=b"", order=False):
    return raw(f"{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}\n", data)


def raw(header, data=b"", version=1):
    size = struct.pack("<H" if version == 1 else "<I", len(header))
    return b"\x93NUMPY" + bytes([version, 0]) + size + header.encode() + data


def good(shape):
    return f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}}}"


# fmt: off
ARRAYS = [
    (b"", "expected a file of numpy.save, got EOF"),
    (b"PK\x03\x04" + bytes(100), "magic string is not correct"),
    (b"\x80\x04\x95" + bytes(100), "magic string is not correct"),
    (b"\x93NUMPY\x09\x00" + bytes(100), "expected numpy's format 1.0 or 2.0, got 9.0"),
    (b"\x93NUMPY\x02\x00\xff\xff\xff\xff{", "expected a header of at most 10,000 bytes, got 4,294,967,295"),
    (array((10**6, 10**6)), "expected 8,000,000,000,000 bytes of data, got 0; the file is truncated"),
    (raw(good(f"({'9' * 4000}, 1)")), "expected far more of data, got 0"),
    (array((3, 4), data=bytes(95)), "expected 96 bytes of data, got 95; the file is truncated"),
    (array((3, 3), "|O", b"cos\nsystem\n" * 9), "expected bools, integers or floats, got object"),
    (array((10**8, 10**8), "|V0"), "expected bools, integers or floats, got |V0"),
    (array((3, 3), "<c16", bytes(144)), "got complex128"),
    (array((3, 3), "<U1", bytes(36)), "got <U1"),
    (array((3, 3), "<M8[s]", bytes(72)), "got datetime64"),
    (raw("{'descr': [('a', '<f8')], 'fortran_order': False, 'shape': (2, 2)}", bytes(64)), "got [('a', '<f8')]"),
    (array((9,), data=bytes(72)), "expected rows and columns, or levels, rows and columns, got an array of shape (9,)"),
    (array((), data=bytes(8)), "shape ()"),
    (array((2, 2, 2, 1), data=bytes(64)), "shape (2, 2, 2, 1)"),
    (array((0, 5)), "rows and columns, got an array of shape (0, 5)"),
    (array((-3, -3), data=bytes(72)), "shape (-3, -3)"),
    (array((6001, 6000), "|b1", bytes(36_006_000)), "expected at most 36,000,000 cells, got 6,001 x 6,000"),
    (array((6000, 6000), "|b1", bytes(36_000_000)), "expected at most 4,194,304 cells, got 6,000 x 6,000"),
    (array((2, 2), data=np.array([0, 0, np.nan, 0]).tobytes()), "got nan in row 1, column 0; replace it"),
    (array((2, 2), data=np.array([0, np.inf, 0, 0]).tobytes()), "got inf in row 0, column 1"),
    (array((2, 2), data=np.array([0, 1, 2, 0.0]).tobytes()), "occupancies from 0 to 1, or -1 for unknown, got 2.0"),
    (array((2, 2), "<i8", np.array([0, -1, -2, 0]).tobytes()), "-1 for unknown and no lower value, got -2"),
    (array((2, 2), "|b1", b"\x01" * 4), "expected a map with free pixels, got none"),
    (raw("(" * 9000), "expected a file of numpy.save"),
    (raw("-" * 9900 + "1"), "expected a file of numpy.save"),
    (raw("[" * 5000 + "]" * 5000, version=2), "expected a file of numpy.save"),
    (raw(good("(3,"+ "+".join("1" * 4000) + "j)")), "expected a file of numpy.save"),
    (raw("{'descr': " + "(" * 150 + ")" * 150 + ", 'fortran_order': False, 'shape': (2, 2)}"), "numpy.save"),
    (raw("x" * 100_000, version=2), "expected a header of at most 10,000 bytes, got 100,000"),
    (raw("{}"), "expected a file of numpy.save"),
    (raw("{'descr': '<f8', 'fortran_order': 3, 'shape': (2, 2)}", bytes(32)), "fortran_order"),
    (raw(good("'ab'"), bytes(32)), "expected a file of numpy.save"),
    (raw(good("(1.5, 2)"), bytes(32)), "expected a file of numpy.save"),
    (raw(good("(2, 2)").replace("<f8", "(1000000,1000000)f8"), bytes(32)), "expected a file of numpy.save"),
]
# fmt: on


def house(verts):
    text = verts if isinstance(verts, bytes) else json.dumps(verts).encode()
    return b'{"id": "x", "room_num": 1, "verts": ' + text + b"}"


# fmt: off
HOUSES = [
    (b"", "expected JSON, got Expecting value"),
    (b"\xff\xfe\x00\xd8", "expected JSON"),
    (b"nonsense", "expected JSON"),
    (house([[0, 0], [4, 0], [4, 3]])[:-9], "expected JSON"),
    (b"null", "expected the key 'verts' (the outline's corners in metres), got a JSON null; add it"),
    (b"{}", "got a JSON object"),
    (b'{"' + b"k" * 1_000_000 + b'": 1}', "got the keys 'kkk"),
    (b'{"a\\nb": 1}', r"got the keys 'a\nb'"),
    (b"[" * 4_000_000, "JSON nested too deeply"),
    (b'{"verts":' * 400_000, "JSON nested too deeply"),
    (b" " * 4_000_001, "expected a JSON map of at most 4,000,000 bytes, got 4,000,001"),
    (house(None), "verts: expected 3 to 2000 corners [x, y], got a JSON null"),
    (house({"a": 1}), "got a JSON object"),
    (house([]), "got 0"),
    (house([[0, 0], [1, 1]]), "got 2; correct it"),
    (house([[0, 0]] * 2_001), "got 2001"),
    (house([[0, 0], [1, 0], [1, 1, 1]]), "got a list of 3 as number 3"),
    (house([[0, 0], ["1", 0], [1, 1]]), "got ['1', 0.0] as number 2"),
    (house([[0, 0], [True, 0], [1, 1]]), "got [True, 0.0] as number 2"),
    (house([[0, 0], [[1], {}], [1, 1]]), "got [a list of 1, a JSON object]"),
    (house([[0, 0], 5, [1, 1]]), "got 5.0 as number 2"),
    (house(b"[[0, 0], [NaN, 0], [1, 1]]"), "got [nan, 0.0] as number 2"),
    (house(b"[[0, 0], [Infinity, 0], [1, 1]]"), "got [inf, 0.0]"),
    (house(b"[[0, 0], [1e999999999999, 0], [1, 1]]"), "got [inf, 0.0]"),
    (house(b"[[0, 0], [" + b"9" * 5000 + b", 0], [1, 1]]"), "got [inf, 0.0]"),
    (house(b"[[0, 0], [-" + b"9" * 3_900_000 + b", 0], [1, 1]]"), "got [-inf, 0.0]"),
    (house([[0, 0], [1e308, -1e308], [-1e308, 1e308]]), "outline of at most 36,000,000 pixels, got inf"),
    (house([[0, 0], [1e308, 0], [0, 1e308]]), "outline of at most 36,000,000 pixels, got inf"),
    (house([[0, 0], [1e9, 0], [0, 1e9]]), "got 3e+10 x 3e+10 of 0.0333 m; ask for a coarser --resolution"),
    (house([[0, 0], [1e300, 0], [0, 1]]), "expected an outline of at most 36,000,000 pixels"),
    (house([[1e300, 0], [1e300, 1], [1e300, 2]]), "expected an outline around some floor, got a straight line"),
    (house([[0, 0], [1, 0], [2, 0]]), "got a straight line"),
    (house([[0, 0]] * 3), "got a straight line"),
    (house([[0, 0], [1e-9, 0], [0, 1e-9]]), "expected cells smaller than the map, got 0.1 m a cell for a house of"),
    (house([[0, 0], [1e5, 0], [1e5, 0.001]]), "for a house of 0.001 m x 1e+05 m"),
]
# fmt: on


def segment(*ends):
    """The JSON of a wall between two ends (x, y)."""
    return json.dumps({f"p{k}": dict(zip("xy", end, strict=False)) for k, end in enumerate(ends)}).encode()


def walls(*segments):
    return b"[" + b",".join(segments) + b"]"


#: Four walls around 6 m x 5 m.
BOX = [segment(a, b) for a, b in pairwise([(0, 0), (6, 0), (6, 5), (0, 5), (0, 0)])]


# fmt: off
WALLS = [
    (b"[]", "expected a list of 1 to 20,000 wall segments, got 0; is it a map?"),
    (b"[[" * 1_999_999, "JSON nested too deeply"),
    (b"[" + b"{}," * 1_300_000 + b"{}]", "got 1300001"),
    (b"[" + b'{"a":0},' * 450_000 + b"{}]", "got 450001"),
    (walls(*BOX)[:-3], "expected JSON"),
    (walls(*BOX, b"5"), "of finite numbers, got 5.0 in number 5; correct it"),
    (walls(*BOX, b"null"), "got a JSON null in number 5"),
    (walls(*BOX, b"{}"), "got a JSON null, a JSON null in number 5"),
    (walls(b'[{"x": 0, "y": 0}]'), "got a list of 1 in number 1"),
    (walls(segment((0, 0))), "got 0.0, 0.0, a JSON null in number 1"),
    (walls(segment((0, 0), (1,))), "got 0.0, 0.0, 1.0, a JSON null in number 1"),
    (walls(b'{"p0": [0, 0], "p1": {"x": 1, "y": 2}}'), "got [0.0, 0.0], 1.0, 2.0 in number 1"),
    (walls(*BOX, segment((0, 0), ("1", 0))), "got 0.0, 0.0, '1', 0.0 in number 5"),
    (walls(*BOX, segment((0, 0), (True, 0))), "got 0.0, 0.0, True, 0.0 in number 5"),
    (walls(*BOX, segment((0, 0), ("a\n" * 1000, 0))), "in number 5"),
    (walls(*BOX, segment((0, float("nan")), (1, 0))), "got 0.0, nan, 1.0, 0.0 in number 5"),
    (walls(*BOX, segment((0, float("-inf")), (1, 0))), "got 0.0, -inf, 1.0, 0.0 in number 5"),
    (walls(*BOX, b'{"p0":{"x":1e999,"y":0},"p1":{"x":' + b"9" * 5000 + b',"y":0}}'), "got inf, 0.0, inf, 0.0"),
    (walls(*BOX, segment((0, 0), (1e300, 0))), "expected points within 1,000,000 m of the origin, got 1e+300"),
    (walls(*BOX, segment((0, 0), (-1.1e6, 0))), "got 1.1e+06; correct it"),
    (walls(*BOX, segment((-1e6, -1e6), (1e6, 1e6))), "of at most 36,000,000 pixels of 0.1 m, got 20,000,040 x"),
    (walls(*BOX, segment((0, 0), (500, 500))), "at most 4,194,304 cells, got 5,040 x 5,040; ask for a coarser"),
    (walls(segment((0, 0), (5, 0))), "expected walls around some floor, with gaps of at most 1.6 m, got none"),
    (walls(segment((0, 0), (0, 0))), "expected walls around some floor, with gaps of at most 1.6 m, got none"),
]
# fmt: on


def points(*places):
    return "".join(f'<point x="{x}" y="{y}" />' for x, y in places)


def space(*corners, rest=""):
    return f"<space><bounding_polygon>{points(*corners)}</bounding_polygon>{rest}</space>"


def portal(*places, kind="PORTAL"):
    segments = f"<linesegment>{points(*places)}<class>{kind}</class></linesegment>"
    return f"<space_representation>{segments}</space_representation>"


#: 10 units are a metre.
SCALE = (
    "<scale><represented_distance><value>10</value><um>pixel</um></represented_distance>"
    "<real_distance><value>100</value><um>cm</um></real_distance></scale>"
)


def building(*spaces, scale=SCALE):
    return f"<building>{scale}<floor><spaces>{''.join(spaces)}</spaces></floor></building>".encode()


#: A room of 6 m x 5 m.
ROOM = space((0, 0), (60, 0), (60, 50), (0, 50))
LAUGHS = '<!ENTITY a0 "ha">' + "".join(f'<!ENTITY a{k} "{f"&a{k - 1};" * 10}">' for k in range(1, 30))


# fmt: off
BUILDINGS = [
    (b"", "expected plain XML, got no element found"),
    (b"nonsense", "expected plain XML, got syntax error: line 1, column 0; correct it"),
    (b"\x00\x01", "expected plain XML"),
    (b"\xff\xfe\x00\xd8", "expected plain XML"),
    (building(ROOM)[:-9], "expected plain XML"),
    (building(ROOM) * 2, "expected plain XML, got junk after document element"),
    (b"<?xml version='1.0' encoding='nonsense'?>" + building(ROOM), "expected plain XML, got unknown encoding"),
    (b"<?xml version='1.0' encoding='utf-7'?>" + building(ROOM), "expected plain XML"),
    (f"<!DOCTYPE b [{LAUGHS}]>".encode() + building(ROOM, "&a29;"), "got a DOCTYPE, which may declare entities"),
    (b"<!DOCTYPE b SYSTEM 'file:///etc/passwd'>" + building(ROOM), "got a DOCTYPE"),
    (b"<!DOCTYPE b [<!ENTITY x SYSTEM 'file:///etc/passwd'>]>" + building("&x;"), "got a DOCTYPE"),
    (b"<!DOCTYPE building>" + building(ROOM), "got a DOCTYPE"),
    (building(ROOM, "&x;"), "expected plain XML, got undefined entity"),
    (b"<building>" * 100_000, "got elements nested deeper than 32 levels"),
    (b"<building>" + b"<a/>" * 490_000 + b"</building>", "got 0 with 0; is it a floor of rooms?"),
    (b"<building>" + b'<a b=""/>' * 220_000 + b"</building>", "got 0 with 0; is it a floor of rooms?"),
    (b" " * 2_000_001, "expected an XML map of at most 2,000,000 bytes, got 2,000,001"),
    (b"<svg/>", "expected the element <building>, got <svg>; is it a floor of rooms?"),
    (b"<" + b"s" * 100_000 + b"/>", "expected the element <building>, got <sss"),
    (building(ROOM, scale=""), "scale/real_distance/um: expected one of mm, cm, m, got 'nothing'; correct it"),
    (building(ROOM, scale=SCALE.replace("cm", "inch\n" * 99)), r"got 'inch\ninch"),
    (building(ROOM, scale=SCALE.replace("100", "-1")), "scale/real_distance/value: expected a number from 0.001"),
    (building(ROOM, scale=SCALE.replace("100", "nan")), "got 'nan'; correct it"),
    (building(ROOM, scale=SCALE.replace("100", "1e300")), "got '1e300'"),
    (building(ROOM, scale=SCALE.replace(">10<", ">0<")), "scale/represented_distance/value: expected a number"),
    (building(ROOM, scale=SCALE.replace(">10<", "><")), "got ''"),
    (building(ROOM).replace(b"<floor>", b"<floor></floor><floor>"), "expected one floor, got 2; save each in"),
    (building(), "expected 1 to 1,000 spaces with 1 to 5,000 corners in their bounding_polygon, got 0 with 0"),
    (building("<space/>"), "got 1 with 0; is it a floor of rooms?"),
    (building(ROOM * 1_001), "got 1,001 with 4,004"),
    (building(space(*[(k % 7, k % 5) for k in range(5_001)])), "got 1 with 5,001"),
    (building(space((0, 0), (60, 50))), "bounding_polygon: expected at least 3 points, got 2; correct it"),
    (building(ROOM, "<space><bounding_polygon><point/></bounding_polygon></space>"), "expected numbers x and y of"),
    (building(space((0, 0), ("nan", 0), (0, 9))), "point: expected numbers x and y of at most 1000000000"),
    (building(space((0, 0), ("six", 0), (0, 9))), "expected numbers x and y"),
    (building(space((0, 0), (9, "1e999"), (0, 9))), "expected numbers x and y"),
    (building(space((0, 0), (60, 0), (60, 50), rest=portal((0, "left")))), "expected numbers x and y"),
    (building(space((0, 0), (1e9, 0), (0, 1e9))), "expected points within 1,000,000 m of the origin, got 1e+08"),
    (building(space((0, 0), (1e7, 0), (0, 1e7))), "36,000,000 pixels of 0.1 m, got 10,000,020 x 10,000,020"),
    (building(space((0, 0), (5000, 0), (0, 5000))), "at most 4,194,304 cells, got 5,020 x 5,020"),
]
# fmt: on


#: A million elements: as the row after each, whose elements take more memory.
SLOW = [b"[" + b"{}," * 1_300_000 + b"{}]", b"<building>" + b"<a/>" * 490_000 + b"</building>"]
BROKEN = {"map": GRIDS, "npy": ARRAYS, "json": HOUSES + WALLS, "xml": BUILDINGS}
ROWS = [(f"bad.{kind}", *row) for kind, rows in BROKEN.items() for row in rows]


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [pytest.param(*row, marks=[pytest.mark.slow] * (row[1] in SLOW)) for row in ROWS],
    ids=range(len(ROWS)),
)
def test_a_broken_file_is_refused(tmp_path, name, data, message):
    assert message in refusal(tmp_path, name, data)


@pytest.mark.parametrize("resolution", [0.0, -1.0, float("nan"), float("inf"), 1e300, 50.0, 1e-9, 0.05])
@pytest.mark.parametrize(
    ("name", "data"),
    [("walls.json", walls(*BOX)), ("rooms.xml", building(ROOM)), ("a.json", house([[0, 0], [8, 0], [8, 5]]))],
)
def test_an_impossible_resolution_of_a_drawn_building_is_refused(tmp_path, name, data, resolution):
    (tmp_path / name).write_bytes(data)
    assert read_map(tmp_path / name, 0.1).resolution == 0.1
    if name == "a.json" and resolution == 0.05:  # a house is drawn as fine as asked for
        return
    with pytest.raises(
        InputError,
        match=r"expected (a resolution (above 0|of at least the source's 0.1)|cells small|an outline of at most)",
    ):
        read_map(tmp_path / name, resolution)


def test_a_house_that_crosses_itself_is_read(tmp_path):
    (tmp_path / "bow.json").write_bytes(house([[0, 0], [4, 3], [4, 0], [0, 3]]))
    assert read_map(tmp_path / "bow.json").kept > 0.4


@pytest.mark.parametrize("suffix", READERS)
def test_nothing_but_a_regular_file_is_opened(tmp_path, suffix):
    path = tmp_path / f"map{suffix}"
    os.mkfifo(path)
    with pytest.raises(InputError, match="expected a regular file, got a pipe or device"):
        read_map(path)
    path.unlink()
    path.mkdir()
    with pytest.raises(InputError, match="expected a file, got a directory"):
        read_map(path)
    (tmp_path / f"null{suffix}").symlink_to("/dev/zero")
    with pytest.raises(InputError, match="got a pipe or device"):
        read_map(tmp_path / f"null{suffix}")


@pytest.mark.parametrize("examples", [20, *slow(60)])
@pytest.mark.parametrize("suffix", READERS)
def test_junk_is_refused_in_one_line(tmp_path, suffix, examples):
    @settings(max_examples=examples, deadline=None)
    @given(st.one_of(st.binary(max_size=300), st.text(max_size=300).map(str.encode)))
    def refuse(data):
        refusal(tmp_path, f"junk{suffix}", data)

    refuse()


def picture(name):
    data, pixels = io.BytesIO(), np.random.default_rng(0).integers(0, 255, (16, 16)).astype(np.uint8)
    Image.fromarray(pixels).save(data, format={"png": "PNG", "pgm": "PPM", "bmp": "BMP"}[name[-3:]])
    return data.getvalue()


def whole(name):
    """A good small file of each kind."""
    body = "\n".join(["......", ".@@...", "......"])
    return (
        picture(name)
        if name.startswith("picture")
        else {
            "grid.map": grid(3, 6, body),
            "array.npy": array((3, 4), "<i4", bytes(48)),
            "house.json": house([[0, 0], [2, 0], [2, 1.5], [0, 1.5]]),
            "walls.json": walls(*BOX),
            "rooms.xml": building(space((0, 0), (60, 0), (60, 50), (0, 50), rest=portal((30, 0)))),
        }[name]
    )


@pytest.mark.parametrize("examples", [50, *slow(150)])
@pytest.mark.parametrize(
    "name",
    ["grid.map", "array.npy", "house.json", "walls.json", "rooms.xml", "picture.png", "picture.pgm", "picture.bmp"],
)
def test_damage_is_refused_in_one_line_or_read_in_spite_of_it(tmp_path, name, examples):
    path = tmp_path / name

    @settings(max_examples=examples, deadline=None)
    @given(st.data())
    def read(data):
        damaged = bytearray(whole(name))
        for place in data.draw(st.lists(st.integers(0, len(damaged) - 1), max_size=4)):
            damaged[place] = data.draw(st.integers(0, 255))
        cut = data.draw(st.one_of(st.none(), st.integers(0, len(damaged))))
        path.write_bytes(bytes(damaged[:cut]))
        assert "\n" not in outcome(path)

    read()


def outcome(path):
    """Return what a file that may be read or refused gives: its digest, or the message, which names it."""
    try:
        return read_map(path).digest
    except InputError as error:
        message = str(error)
    assert str(path) in message
    return message
