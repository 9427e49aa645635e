"""Buildings of Open-RMF: scales, walls, doors with lintels, slabs, shafts, and one line for what is wrong."""

import copy

import numpy as np
import pytest
import yaml

from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.maps.files import read_map
from indoor_explorers.env.maps.readers.rmf import BuildingSettings, parse_rmf
from indoor_explorers.env.maps.sources import FileMaps
from tests.env.maps.readers.flights import flown
from tests.env.maps.test_bad_files import refusal

#: Two rooms of 5 m x 5 m, where 20 pixels are a metre, a door of 1 m between them, and a lift in the right one.
CORNERS = [(0, 0), (100, 0), (200, 0), (200, 100), (100, 100), (0, 100), (100, 40), (100, 60)]
RING = [0, 1, 2, 3, 4, 5]
MARKS = [[0, 0, "a"], [200, 0, "b"], [200, 100, "c"]]
LIFT = {
    "x": 170, "y": 50, "yaw": 0, "width": 2, "depth": 2, "reference_floor_name": "L1", "lowest_floor": "L1",
    "highest_floor": "L2", "level_doors": {"L1": ["d"], "L2": ["d"]},
    "doors": {"d": {"x": -1.0, "y": 0, "width": 1.2, "motion_axis_orientation": 1.5708}},
}  # fmt: skip


def level(elevation, place=lambda x, y: (x, y)):
    return {
        "elevation": elevation,
        "vertices": [[*place(x, y), 0, ""] for x, y in CORNERS],
        "walls": [[one, other, {}] for one, other in [*zip(RING, [*RING[1:], 0], strict=True), (1, 6), (7, 4)]],
        "doors": [[6, 7, {"name": [1, "door"]}]],
        "floors": [{"vertices": RING, "parameters": {}}],
        "fiducials": [[*place(x, y), name] for x, y, name in MARKS],
        "measurements": [[0, 2, {"distance": [3, 10.0]}]],
    }


@pytest.fixture
def tower():
    """Two storeys; the drawing of the upper one is turned by a right angle, moved and twice as large."""
    upper = level(3.5, lambda x, y: (500 - 2 * y, 70 + 2 * x))
    del upper["measurements"]
    return {"name": "tower", "levels": {"L2": upper, "L1": level(0.0)}, "lifts": {"lift": LIFT}}


def saved(folder, building):
    path = folder / "tower.building.yaml"
    path.write_text(yaml.safe_dump(building))
    return path


def free_of(plan):
    return np.array(plan.levels.volume(plan.truth)) == FREE


def test_storeys_lie_above_each_other_by_their_fiducials(tower, tmp_path):
    tower["reference_level_name"] = "L1"
    lower, upper = parse_rmf(saved(tmp_path, tower))
    assert (lower.name, upper.name) == ("L1", "L2")
    np.testing.assert_allclose(upper.walls, lower.walls, atol=1e-9)
    assert np.abs(lower.walls).max() == pytest.approx(abs(10 + 5j))
    assert len(lower.shafts) == len(upper.gates) == 1


def test_doors_have_lintels_slabs_close_and_shafts_join(tower, tmp_path):
    tower["reference_level_name"] = "L1"
    plan = read_map(saved(tmp_path, tower))
    free = free_of(plan)
    assert (plan.name, plan.level_count, plan.resolution) == ("tower", 11, 0.5)
    assert plan.kept > 0.98
    storey = free[0]
    assert 9 * 18 - 50 < storey.sum() < 10 * 20
    np.testing.assert_array_equal(free[:4], [storey] * 4)  # a door of 2.1 m is four cells of half a metre high
    np.testing.assert_array_equal(free[6:10], [storey] * 4)
    lintel = storey & ~free[4]
    assert 1 <= lintel.sum() <= 6
    assert {*np.argwhere(lintel)[:, 1]} <= {10, 11, 12}
    assert 4 <= free[5].sum() <= 16  # the shaft alone
    assert not (free[5] & ~storey).any()


def test_a_hole_in_a_floor_opens_the_slab(tower, tmp_path):
    tower["reference_level_name"] = "L1"
    solid = free_of(read_map(saved(tmp_path, tower)))[5]
    tower["levels"]["L2"]["vertices"] += [[*(500 - 2 * y, 70 + 2 * x), 0] for x, y in [(20, 20), (60, 20), (60, 60)]]
    tower["levels"]["L2"]["holes"] = [{"vertices": [8, 9, 10]}]
    assert (free_of(read_map(saved(tmp_path, tower)))[5] & ~solid).sum() >= 4


def test_heights_come_from_settings_or_from_elevations(tower, tmp_path):
    path = saved(tmp_path, tower)
    assert read_map(path, None, BuildingSettings(storey_height=0)).level_count == 13
    low = free_of(read_map(path, None, BuildingSettings(door_height=1.0)))
    assert low[1].sum() > low[2].sum()
    assert read_map(path, 0.25).level_count == 23


def test_one_storey_is_a_plane_and_a_building_of_one_is_read_too(tower, tmp_path):
    path = saved(tmp_path, tower)
    plane = read_map(path, None, BuildingSettings(storey="L1"))
    assert (plane.name, plane.level_count) == ("tower-L1", 1)
    asked = FileMaps(paths=(str(path),), building={"storey": "L2"})
    assert asked.level_count == asked.floorplan(0, 0).level_count == 1
    del tower["levels"]["L2"]
    assert read_map(saved(tmp_path, tower)).level_count == 5
    assert refusal_of_storey(path, "L7").endswith("known: L1")


def refusal_of_storey(path, name):
    with pytest.raises(ValueError, match=f"no storey '{name}' with walls and floors") as caught:
        read_map(path, None, BuildingSettings(storey=name))
    return str(caught.value)


def test_a_scenario_counts_the_levels_anew_when_a_setting_changes_them(tower, tmp_path):
    maps = FileMaps(paths=(str(saved(tmp_path, tower)),))
    assert maps.level_count == 11
    assert FileMaps.model_validate(maps.model_dump() | {"resolution": 0.25}).level_count == 23
    assert maps.without_files().level_count == 11


def test_a_uav_flies_through_a_building(tower, tmp_path):
    path = saved(tmp_path, tower)
    assert 0.0 < flown(path, steps=5) < flown(path) == 1.0


# fmt: off
@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (["levels"], [], "levels: expected a mapping of levels by name, got []"),
        (["levels", "L1"], "x", "levels: expected a mapping of levels by name"),
        (["coordinate_system"], "wgs84", "expected reference_image or cartesian_meters, got 'wgs84'"),
        (["levels"], {"L1": {"lanes": []}}, "levels: expected one with walls and floors, got L1"),
        (["levels", "L1", "elevation"], "high", "elevation: expected metres, got others"),
        (["levels", "L1", "vertices"], [[1]], "levels: L1: vertices: expected lists [x, y, ...] of numbers"),
        (["levels", "L1", "vertices"], [["1", "inf"]], "levels: L1: vertices: expected lists"),
        (["levels", "L1", "walls"], [[0, 99]], "levels: L1: walls: expected lists [vertex, vertex, ...]"),
        (["levels", "L1", "doors"], [["a", "b"]], "levels: L1: doors: expected lists"),
        (["levels", "L1", "floors"], [[1, 2, 3]], "levels: L1: floors: expected mappings with vertices"),
        (["levels", "L1", "fiducials"], [[1, 2]], "levels: L1: fiducials: expected lists [x, y, name]"),
        (["levels", "L1", "measurements"], [], "measurements: expected lists [vertex, vertex, {distance:"),
        (["levels", "L1", "measurements"], [[0, 0, {"distance": [3, 1]}]], "measurements: expected lists"),
        (["levels", "L1", "measurements"], [[0, 1, {"distance": [3, 1e9]}]], "measurements: expected lists"),
        (["lifts"], {"lift": {"x": 1}}, "lifts: expected x, y, yaw, width, depth"),
    ],
)
def test_what_is_wrong_is_told_in_one_line(tower, tmp_path, place, value, message):
    building = copy.deepcopy(tower) | {"reference_level_name": "L1"}
    inner = building
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    assert message in refusal(saved(tmp_path, building))
# fmt: on


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expected lines such as 'levels: ...', got an empty file; is it a building of Open-RMF?"),
        ("[" * 10_000, "nested deeper"),
        ("levels: {a: &a [*a]}", "expected"),
        ("a: [", "expected YAML"),
    ],
)
def test_other_text_is_refused(tmp_path, text, message):
    path = tmp_path / "tower.building.yaml"
    path.write_text(text)
    assert message in refusal(path)
