"""Maps in the terminal: pictures that fit and show what matters, and the facts; the command ``maps``."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from indoor_explorers.env import scenario
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.maps.files import read_map
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.kinds import statistics_of
from indoor_explorers.env.maps.sources import MazeMaps, OfficesMaps
from indoor_explorers.env.search.connected_parts import connected_parts
from indoor_explorers.env.simulation.spawns import draw_floorplan
from indoor_explorers.evaluation.cli.commands.compare import file_notes
from indoor_explorers.evaluation.cli.map_text import _coarse, facts, layout, picture, statistics
from indoor_explorers.evaluation.cli.parser import main
from indoor_explorers.evaluation.harness.experiment.planning import plan as plan_of
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from tests.evaluation.cli.test_cli import run


def plan(text, **more):
    free = np.array([[char != "#" for char in line] for line in text.split()])
    starts = [(row, line.index("S")) for row, line in enumerate(text.split()) if "S" in line]
    return Floorplan.from_free(free, "plan", start=starts[0] if starts else None, **more)


def test_a_small_map_is_drawn_cell_by_cell():
    assert picture(plan("##### #...# #.#.# #...# #####"), 80) == "█▀▀▀█\n█ ▀ █\n▀▀▀▀▀"
    assert picture(plan("##### #...# #.#S# #...# #####"), 80) == "█▀▀▀█\n█ ▀S█\n▀▀▀▀▀"


def test_a_wider_map_is_drawn_dot_by_dot():
    assert picture(plan("######## #......# #.####.# #......# ########"), 4) == "⡏⠭⠭⢹\n⠉⠉⠉⠉"
    assert picture(plan("######## #......# #.####.# #.....S# ########"), 4) == "⡏⠭⠭S\n⠉⠉⠉⠉"


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 300), st.integers(1, 300), st.integers(1, 130), st.integers(0, 99))
def test_every_picture_fits_and_shows_the_start(height, width, columns, seed):
    free = np.random.default_rng(seed).random((height, width)) < 0.7
    free[height // 2, width // 2] = True
    start = tuple(int(place) for place in np.argwhere(free)[seed % free.sum()])
    lines = picture(Floorplan.from_free(free, "noise", start=start), columns).split("\n")
    assert len({len(line) for line in lines}) == 1
    assert len(lines[0]) <= columns
    assert "".join(lines).count("S") == 1


def test_doors_of_large_maps_stay_open():
    office = OfficesMaps(height=200, width=700, door=(3, 4)).floorplan(0, 0)
    coarse = _coarse(office.truth, office.name, 3)
    assert coarse.shape == (67, 234)
    assert len(connected_parts(coarse)[1]) == 2
    assert coarse.sum() * 9 > 0.5 * (office.truth == FREE).sum()
    lines = picture(office, 120).split("\n")
    assert (len(lines), len(lines[0])) == (17, 117)


@pytest.mark.parametrize("corridor", [1, 3])
def test_the_largest_maze_is_drawn_though_its_corridors_are_finer_than_dots(corridor):
    lines = picture(MazeMaps(height=2048, width=2048, corridor=corridor).floorplan(0, 0), 120).split("\n")
    assert (len(lines[0]), len(lines)) == (114, 57)


def test_the_facts_of_a_map():
    assert facts(plan("#### #..# #### #.##", resolution=0.5, kept=0.75)) == (
        "plan: 4 x 4 cells, 0.5 m a cell, 3 free (0.8 m2), 66.7% of the source's free area connected, 75.0% kept"
    )
    assert facts(plan("#S.")).startswith(
        "plan: 1 x 3 cells, no scale, 2 free, 100.0% of the source's free area connected, "
    )
    assert facts(plan("#S.")).endswith("% kept; start at (0, 1)")


def test_the_share_connected_before_the_cut_is_told_and_a_small_one_is_a_caution(tmp_path, capsys):
    grey = np.zeros((250, 250), np.uint8)
    grey[:, :60], grey[:, 100::2] = 255, 255
    Image.fromarray(grey).save(tmp_path / "photo.png")
    _, out, _ = run(capsys, "maps", tmp_path / "photo.png")
    assert "44.4% of the source's free area connected, 44.4% kept" in out
    assert "photo: only 44.4% of the free area is left, the largest connected part: is it a map" in out
    assert "photo.png: a picture has no scale: a pixel is taken for 1 m; --resolution 3 makes 100 cells" in out


def test_a_mask_of_what_is_free_and_a_turned_origin_are_told(tmp_path, capsys):
    free = np.zeros((22, 32), np.bool_)
    free[1:-1, 1:-1] = True
    np.save(tmp_path / "mask.npy", free)
    np.save(tmp_path / "walls.npy", ~free)
    Image.fromarray(np.full((4, 4), 254, np.uint8)).save(tmp_path / "m.pgm")
    for name, yaw in (("turned", 0.7853), ("straight", 0)):
        lines = ("image: m.pgm", "resolution: 1", f"origin: [0, 0, {yaw}]", "negate: 0", "occupied_thresh: 0.65")
        (tmp_path / f"{name}.yaml").write_text("\n".join([*lines, "free_thresh: 0.196"]))
    files = [tmp_path / name for name in ("mask.npy", "walls.npy", "turned.yaml", "straight.yaml")]
    assert [len(read_map(file).notes) for file in files] == [1, 0, 1, 0]
    _, out, _ = run(capsys, "maps", *files)
    told = (
        "mask.npy: the border is free and the inside is not: True is a wall; if it was to be free, save ~mask",
        "turned.yaml: the map is flown as its picture lies: the yaw of its origin, 0.7853 rad, is ignored",
    )
    assert all(line in out for line in told)
    asked = ComparisonRequest(maps=[*map(str, files)], policies="random")
    assert file_notes(plan_of(asked)) == [*told]


@pytest.mark.parametrize("name", ["thesis-obstacles", "office", "rooms", "offices", "cave", "maze"])
def test_the_maps_of_a_scenario_are_shown(capsys, name):
    status, out, errors = run(capsys, "maps", "--scenario", name)
    assert (status, errors) == (0, "")
    assert "% of the source's free area connected" in out
    assert (run(capsys, "maps", "--scenario", name, "--seed", 1)[1] == out) == (name == "office")
    assert run(capsys, "maps", "--scenario", name, "--seed", 0)[1] == out


def test_settings_of_the_scenario_count(capsys):
    words = ["maps", "--scenario", "maze", "--set", "map.height=21", "map.width=37", "map.corridor=1"]
    assert "maze: 21 x 37 cells" in run(capsys, *words)[1]


def test_files_of_every_kind_are_shown(capsys, tmp_path):
    np.save(tmp_path / "a.npy", np.zeros((3, 4), np.uint8))
    (tmp_path / "b.map").write_text("type octile\nheight 2\nwidth 3\nmap\n...\n.@.\n")
    (tmp_path / "c.json").write_text('{"verts": [[0, 0], [2, 0], [2, 1], [0, 1]]}')
    status, out, _ = run(capsys, "maps", *(tmp_path / name for name in ("a.npy", "b.map", "c.json")))
    assert status == 0
    for line in ("a: 3 x 4 cells, 1 m a cell, 12 free", "b: 2 x 3 cells", "c: 12 x 22 cells, 0.1 m a cell, 200 free"):
        assert line in out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "expected the paths of map files, a --scenario or a --suite, got none"),
        (["a.png", "--scenario", "maze"], "got several"),
        (["--suite", "rooms", "--scenario", "maze"], "got several"),
        (["--suite", "romos"], "did you mean 'rooms'"),
        (["--suite", "floors"], "suite 'floors' lacks map files below --data"),
        (["--suite", "rooms", "--seed", "1"], "expected --scenario with --seed, got maps that have none"),
        (["--suite", "rooms", "--set", "map.height=5"], "expected --scenario or map files with --set, got a suite"),
        (["a.png", "--seed", "3"], "expected --scenario with --seed, got maps that have none"),
        (["a.png", "--set", "map.height=5"], "no setting 'map.height'"),
        (["--scenario", "maez"], "did you mean 'maze'"),
        (["--scenario", "maze", "--resolution", "2"], "expected map files with --resolution, got other maps"),
        (["--scenario", "maze", "--set", "map.corridr=2"], "did you mean 'map.corridor'"),
        (["--scenario", "maze", "--set", "map.height=9999"], "less than or equal to 2048"),
        (["nowhere.map"], "nowhere.map: expected a file"),
    ],
)
def test_what_cannot_be_shown_is_said_in_one_line(capsys, words, message):
    status, out, errors = run(capsys, "maps", *words)
    assert (status, out) == (2, "")
    assert message in errors
    assert errors.count("\n") == 1


@pytest.mark.parametrize("name", ["small-floors", "thesis-obstacles", "office"])
def test_a_saved_map_is_read_with_the_same_cells(name, tmp_path, capsys):
    saved = tmp_path / "floor.png"
    assert main(["maps", "--scenario", name, "--seed", "2", "--save", str(saved)]) == 0
    drawn = draw_floorplan(scenario(name), 2)
    largest = np.where(drawn.main_part, drawn.truth, 2)
    np.testing.assert_array_equal(read_map(saved).truth, largest)
    assert f"Map: {saved}" in capsys.readouterr().out


@pytest.mark.parametrize("kind", ["npy", "bt"])
def test_a_saved_map_of_several_levels_is_read_with_the_same_cells(kind, tmp_path, capsys):
    saved = tmp_path / f"tower.{kind}"
    assert main(["maps", "--scenario", "small-storeys", "--seed", "2", "--save", str(saved)]) == 0
    assert read_map(saved).digest == draw_floorplan(scenario("small-storeys"), 2).digest
    assert f"Map: {saved}" in capsys.readouterr().out


def test_files_of_different_heights_are_told_with_their_own_levels(tmp_path, capsys):
    walls = np.ones((3, 6, 8), np.int8)
    walls[:2, 1:5, 1:7] = 0
    np.save(tmp_path / "flat.npy", walls[0])
    np.save(tmp_path / "tall.npy", walls)
    assert main(["maps", str(tmp_path / "flat.npy"), str(tmp_path / "tall.npy")]) == 0
    told = capsys.readouterr().out
    assert "flat: 6 x 8 cells" in told
    assert "tall: 3 x 6 x 8 cells" in told


def test_rooms_are_counted_on_each_level_and_levels_that_are_alike_told_together():
    level = np.pad(np.ones((5, 11), np.bool_), 1)
    level[:, 6] = level[0, 6]
    level[3, 6] = True  # two rooms and a door
    slab = np.zeros_like(level)
    slab[2, 2] = True
    tower = Floorplan.from_free(np.stack([level, level, slab, level]), "tower", resolution=0.5)
    rooms = "56% free; 2 rooms, 0 corridors, 1 door, 0 loops; at most 1 passage from one to another"
    lines = layout(tower).split("\n")
    assert [lines[0], lines[2]] == [f"levels 0 to 1: {rooms}", f"level 3: {rooms}"]
    assert lines[1].startswith("level 2: 1% free; 1 room")
    assert "154 free (19.2 m3)" in facts(tower)
    alone = statistics_of(Floorplan.from_free(level, "floor", resolution=0.5))
    assert statistics_of(Floorplan.from_free(np.stack([level, level]), "tower", resolution=0.5)) == pytest.approx(alone)
    assert statistics(tower, statistics_of(tower)).startswith(f"{alone.kind}, mean over levels: clearance ")


@pytest.mark.parametrize("where", ["floor.pgm", "no-folder/floor.png"])
def test_what_cannot_be_saved_is_told_in_one_line(where, tmp_path, capsys):
    assert main(["maps", "--scenario", "office", "--save", str(tmp_path / where)]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_the_rooms_and_doors_of_a_map_are_told():
    rooms = "################ #......##......# #......##......# #......##......# #..............# ################"
    assert layout(plan(rooms, resolution=0.5)) == (
        "2 rooms, 0 corridors, 1 door, 0 loops; at most 1 passage from one to another"
    )
    assert layout(plan(rooms, resolution=0.1)) == (  # where 1.5 m are 15 cells, all of it is one narrow place
        "1 room, 0 corridors, 0 doors, 0 loops; at most 0 passages from one to another"
    )


def test_the_kind_and_the_statistics_of_a_map_are_told():
    empty = Floorplan.from_free(np.ones((4, 6), np.bool_), "empty", 0.5)
    assert statistics(empty, statistics_of(empty)) == (
        "hall: clearance 0.67 m, openness 0.08, 100% of the floor in view, 1.0 effective rooms, 0% corridors, "
        "100% of one width, solidity 1.00, walls 60% straight"
    )
    unscaled = Floorplan.from_free(np.ones((4, 6), np.bool_), "empty")
    assert "clearance 1.33 cells" in statistics(unscaled, statistics_of(unscaled))


def test_kinds_are_counted_by_source(capsys, tmp_path):
    for folder, mazes in (("halls", 1), ("mazes", 2)):
        (tmp_path / folder).mkdir()
        np.save(tmp_path / folder / "hall.npy", np.zeros((30, 40), np.uint8))
        for seed in range(mazes):
            walls = MazeMaps(height=41, width=41).floorplan(0, seed).truth != FREE
            np.save(tmp_path / folder / f"maze{seed}.npy", walls)
    _, out, _ = run(capsys, "maps", *sorted((tmp_path / "halls").iterdir()), *sorted((tmp_path / "mazes").iterdir()))
    assert out.splitlines()[-2:] == ["halls: 1 hall, 1 maze", "mazes: 2 maze, 1 hall"]


def test_the_maps_of_a_suite_are_told_without_pictures(capsys):
    status, out, _ = run(capsys, "maps", "--suite", "rooms", "--part", "validation")
    lines = out.splitlines()
    assert (status, lines[-1], len(lines)) == (0, "thesis: 100 hall", 3 * 100 + 1)


def test_levels_are_drawn_beside_each_other_below_their_names(tmp_path):
    free = np.array([[[1, 1, 1], [1, 0, 1]], [[0, 0, 0], [0, 1, 0]], [[1, 1, 1], [1, 1, 1]]], bool)
    tall = Floorplan.from_free(free, "tall", start=(3 + 1, 1))
    assert picture(tall, 80) == "level 0 level 1\n ▄      █S█\nlevel 2\n"
    assert picture(tall, 14) == "level 0\n ▄\nlevel 1\n█S█\nlevel 2\n"
    assert facts(tall).startswith("tall: 3 x 2 x 3 cells, ")
    assert "start at (1, 1, 1)" in facts(tall)


def test_the_command_shows_levels_of_arrays_and_saves_none_as_a_picture(tmp_path, capsys):
    array = np.ones((3, 12, 16), np.uint8)
    array[:, 2:-2, 2:-2] = 0
    np.save(tmp_path / "tall.npy", array)
    status, shown, _ = run(capsys, "maps", tmp_path / "tall.npy")
    assert status == 0
    assert "tall: 3 x 12 x 16 cells" in shown
    assert "level 0" in shown
    assert "level 2" in shown
    status, _, said = run(capsys, "maps", tmp_path / "tall.npy", "--save", tmp_path / "tall.png")
    assert status == 2
    assert "expected a kind of map file that holds 3 levels: .npy or .bt, got '.png'" in said
