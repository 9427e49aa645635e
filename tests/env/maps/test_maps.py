"""Reading maps: what each pixel becomes, which doorways open, what is cut away; the office and the thesis's rooms."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from indoor_explorers.env import InputError
from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.maps.files import read_map
from indoor_explorers.env.maps.readers.image import read_plain
from indoor_explorers.env.maps.readers.ros import RosMap, parse_ros, read_ros, trinary
from indoor_explorers.env.maps.reduction import open_doorways
from indoor_explorers.env.maps.sources import FileMaps, drawn, office

SHARED = Path(__file__).parents[3] / ".." / "shared" / "maps"
needs_shared = pytest.mark.skipif(not SHARED.is_dir(), reason="the development maps (../shared/maps) are not here")

YAML = "image: map.png\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"


def write_ros(folder: Path, pixels: NDArray[np.uint8], yaml: str = YAML) -> Path:
    """Save a map_server map and return the path of its YAML file."""
    Image.fromarray(pixels).save(folder / "map.png")
    (folder / "map.yaml").write_text(yaml)
    return folder / "map.yaml"


def cells(text: str) -> Belief:
    """Turn lines of ``#`` (occupied), ``.`` (free) and ``?`` (unknown) into cells."""
    values = {"#": OCCUPIED, ".": FREE, "?": UNKNOWN}
    return np.array([[values[char] for char in line] for line in text.split()], np.uint8)


def classes(shades: list[int], *, negate: bool = False, occupied: float = 0.65, free: float = 0.196) -> list[int]:
    facts = RosMap(image=Path(), resolution=0.05, negate=negate, occupied_thresh=occupied, free_thresh=free)
    return [int(value) for value in trinary(np.array(shades, np.uint8)[None, :, None], facts)[0]]


def test_the_usual_three_shades_are_occupied_unknown_and_free() -> None:
    assert classes([0, 205, 254]) == [OCCUPIED, UNKNOWN, FREE]


def test_negate_turns_the_shades_around() -> None:
    assert classes([255, 128, 0], negate=True) == [OCCUPIED, UNKNOWN, FREE]


@pytest.mark.parametrize("negate", [False, True])
def test_a_pixel_exactly_at_a_threshold_is_unknown(negate: bool) -> None:
    """An occupancy of 102/255 = 0.4 is not above 0.4, one of 51/255 = 0.2 is not below 0.2."""
    dark = [103, 102, 51, 50]
    shades = dark if negate else [255 - value for value in dark]
    assert classes(shades, negate=negate, occupied=0.4, free=0.2) == [OCCUPIED, UNKNOWN, UNKNOWN, FREE]


@pytest.mark.parametrize(
    ("yaml", "unknown"),
    [
        ("mode: trinary\nfree_thresh: 0.25\n", UNKNOWN),
        ("free_thresh: 0.25\n", FREE),
        ("mode: trinary\nfree_thresh: 0.24\n", FREE),
        ("mode: scale\nfree_thresh: 0.25\n", FREE),
        ("mode: trinary\nfree_thresh: 0.25\nnegate: 1\n", OCCUPIED),
    ],
)
def test_what_nav2_saved_as_unknown_is_unknown(tmp_path: Path, yaml: str, unknown: int) -> None:
    """Nav2's saver writes 205 for unknown cells and a threshold by which they would be free."""
    path = write_ros(tmp_path, np.array([[205]], np.uint8), YAML + yaml)
    assert read_ros(path)[0].tolist() == [[unknown]]


def test_colours_are_averaged_and_alpha_is_ignored(tmp_path: Path) -> None:
    pixels = np.array([[[254, 254, 254, 0], [255, 255, 105, 9], [255, 0, 0, 255], [0, 0, 0, 255]]], np.uint8)
    read, resolution = read_ros(write_ros(tmp_path, pixels))
    assert read.tolist() == [[FREE, UNKNOWN, OCCUPIED, OCCUPIED]]  # occupancies 0.004, 0.196.., 0.667, 1
    assert resolution == 0.05


def test_mode_scale_takes_transparent_pixels_as_unknown(tmp_path: Path) -> None:
    pixels = np.array([[[254, 255], [254, 0], [0, 255], [0, 0]]], np.uint8)
    path = write_ros(tmp_path, pixels, YAML + "mode: scale\n")
    assert read_ros(path)[0].tolist() == [[FREE, UNKNOWN, OCCUPIED, UNKNOWN]]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("negate: 0", "negate: false"),
        ("negate: 0", "negate: 1\nnegate: 0"),
        ("resolution: 0.05", "resolution: 5e-2  # metres"),
        ("origin: [0, 0, 0]", "origin: [-8.3, 1e1, .0]\nauthor: somebody"),
        ("origin: [0, 0, 0]\n", "# no origin\n"),
        ("image: map.png", "image: ./map.png\nmode: Trinary"),
        ("image: map.png\n", "\ufeffimage: 'map.png'\n"),
    ],
)
def test_yaml_as_found_in_the_wild_reads_the_same(tmp_path: Path, old: str, new: str) -> None:
    path = write_ros(tmp_path, np.full((2, 2), 254, np.uint8))
    plain = parse_ros(path)
    path.write_text(YAML.replace(old, new), encoding="utf-8")
    assert parse_ros(path) == plain
    assert read_ros(path)[0].tolist() == [[FREE, FREE]] * 2


def test_a_plain_picture_is_free_above_half_luminance(tmp_path: Path) -> None:
    Image.fromarray(np.array([[0, 127, 128, 195, 203, 255]], np.uint8)).save(tmp_path / "grey.pgm")
    assert (read_plain(tmp_path / "grey.pgm")[0] == FREE).tolist() == [[False, False, True, True, True, True]]
    colours = np.array([[[127, 127, 127], [128, 128, 128], [0, 255, 0], [0, 0, 255], [255, 216, 0]]], np.uint8)
    Image.fromarray(colours).save(tmp_path / "colour.png")
    assert (read_plain(tmp_path / "colour.png")[0] == FREE).tolist() == [[False, True, True, False, True]]


@pytest.mark.parametrize(
    ("suffix", "mode"),
    [(".png", mode) for mode in ("1", "L", "P", "LA", "RGB", "RGBA", "I;16")]
    + [(".pnm", mode) for mode in ("1", "L", "RGB", "I;16")]
    + [(".bmp", mode) for mode in ("1", "L", "P", "RGB", "RGBA")],
)
def test_every_pixel_format_reads_alike(tmp_path: Path, suffix: str, mode: str) -> None:
    wanted = np.array([[255, 0, 255], [255, 255, 255]], np.uint8)
    image = Image.fromarray(wanted)
    image = Image.fromarray(wanted.astype(np.uint16) * 257) if mode == "I;16" else image.convert(mode)
    image.save(tmp_path / f"map{suffix}")
    assert ((read_plain(tmp_path / f"map{suffix}")[0] == FREE) == (wanted > 0)).all()


def test_what_is_transparent_shows_white_paper(tmp_path: Path) -> None:
    drawn = np.array([[[0, 0, 0, 255], [0, 0, 0, 0], [0, 0, 0, 100], [0, 0, 0, 200], [255, 255, 255, 0]]], np.uint8)
    Image.fromarray(drawn).save(tmp_path / "strokes.png")
    assert (read_plain(tmp_path / "strokes.png")[0] == FREE).tolist() == [[False, True, True, False, True]]


def test_plain_pictures_keep_their_canvas_and_lose_what_cannot_be_reached(tmp_path: Path) -> None:
    drawing = cells("####### #...### #...#.# ####### #######")
    Image.fromarray(np.where(drawing == FREE, 255, 0).astype(np.uint8)).save(tmp_path / "room.png")
    plan = read_map(tmp_path / "room.png")
    assert plan.shape == (5, 7)
    assert plan.truth.tolist() == cells("####### #...### #...### ####### #######").tolist()
    assert (plan.name, plan.resolution) == ("room", 1.0)
    assert plan.kept == pytest.approx(6 / 7)


def test_ros_maps_are_cut_to_the_floor_and_one_wall_around_it(tmp_path: Path) -> None:
    pixels = np.full((30, 40), 205, np.uint8)
    pixels[10:15, 20:28] = 254
    pixels[0:2, 0:2] = 254
    plan = read_map(write_ros(tmp_path, pixels), None)
    assert plan.shape == (7, 10)
    assert (plan.truth[1:-1, 1:-1] == FREE).all()
    assert (plan.truth == FREE).sum() == 40
    assert plan.kept == pytest.approx(40 / 44)


def test_floor_at_the_edge_of_the_picture_gets_a_wall(tmp_path: Path) -> None:
    plan = read_map(write_ros(tmp_path, np.full((4, 5), 254, np.uint8)), None)
    assert plan.shape == (6, 7)
    assert (plan.truth == FREE).sum() == 20


def test_unknown_doorways_between_rooms_open() -> None:
    before = cells("....##.... ....??.... ....##....")
    assert open_doorways(before, 0.5).tolist() == cells("....##.... .......... ....##....").tolist()
    assert open_doorways(before.T, 0.5).tolist() == cells("....##.... .......... ....##....").T.tolist()


@pytest.mark.parametrize(
    ("text", "resolution", "why"),
    [
        ("....#?#.... ....#?#....", 0.3, "a wall on both sides"),
        ("....#?.... ....#?....", 0.3, "a wall on one side"),
        ("....???.... ....???....", 0.5, "deeper than a wall is thick"),
        ("....?.##### ....?.#####", 0.5, "a speck, not a room"),
        ("...?... ...?... .......", 0.5, "the same room on both sides"),
    ],
)
def test_other_unknown_strips_stay(text: str, resolution: float, why: str) -> None:
    before = cells(text)
    assert open_doorways(before, resolution).tolist() == before.tolist(), why


def test_an_unknown_ending_or_a_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "map.svg").write_text("<svg/>")
    with pytest.raises(InputError, match=r"map\.svg: expected a map ending in \.yaml.*got '\.svg'"):
        read_map(tmp_path / "map.svg", None)
    with pytest.raises(InputError, match="expected a file, got a directory"):
        read_map(tmp_path, None)


def test_the_office_is_one_connected_floor_of_the_promised_size() -> None:
    plan = office()
    assert plan.shape == (60, 100)
    assert plan.resolution == 0.4
    assert plan.main_part.sum() == (plan.truth == FREE).sum()
    assert 3500 < (plan.truth == FREE).sum() < 4500
    border = np.ones(plan.shape, np.bool_)
    border[1:-1, 1:-1] = False
    assert (plan.truth[border] == OCCUPIED).all()


def test_a_drawing_with_a_slip_says_where_it_is() -> None:
    with pytest.raises(InputError, match="expected 3 characters in line 2, got 2"):
        drawn("###\n#.", "plan")
    with pytest.raises(InputError, match=r"in line 2, got 'x'"):
        drawn("###\n#x#", "plan")


@needs_shared
@pytest.mark.parametrize(
    ("file", "resolution", "shape", "kept"),
    [
        ("slam/Sarmis2_map_adj.yaml", 0.25, (49, 49), 0.95),
        ("slam/UMA_236.yaml", 0.25, (373, 61), 0.95),
        ("slam/g4s_y2.yaml", 0.25, (145, 130), 0.95),
        ("slam/movecare_map1.yaml", 0.25, (57, 47), 0.94),
        ("kth/kth_50052749.yaml", 0.4, (162, 214), 0.98),
        ("kth/kth_50052749.yaml", 0.5, (130, 171), 0.98),
        ("kth/kth_50052752.yaml", 0.5, (51, 157), 0.99),
        ("dungeon/377.png", 4.0, (120, 160), 1.0),
    ],
)
def test_real_maps_keep_their_floor(file: str, resolution: float, shape: tuple[int, int], kept: float) -> None:
    plan = read_map(SHARED / file, resolution)
    assert plan.shape == shape
    assert kept <= plan.kept <= 1.0
    assert plan.main_part.sum() == (plan.truth == FREE).sum()


@needs_shared
def test_a_yaml_that_names_no_picture_says_so() -> None:
    with pytest.raises(InputError, match=r"wrong-image-path\.yaml: image: /.*there is none; correct the path"):
        read_map(SHARED / "slam" / "movecare_map1-wrong-image-path.yaml", None)


def test_files_of_one_name_are_told_apart_by_their_folders(tmp_path):
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        Image.fromarray(np.full((4, 5), 255, np.uint8)).save(tmp_path / folder / "plan.png")
    Image.fromarray(np.full((4, 5), 255, np.uint8)).save(tmp_path / "other.png")
    source = FileMaps(paths=tuple(str(tmp_path / name) for name in ("a/plan.png", "b/plan.png", "other.png")))
    assert [source.floorplan(index, 0).name for index in range(3)] == ["a/plan", "b/plan", "other"]
