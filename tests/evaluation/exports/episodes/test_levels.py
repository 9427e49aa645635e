"""Exports of episodes on maps of several levels, read back and compared with the record."""

import json

import numpy as np
import pandas as pd
import pytest

from indoor_explorers.env import OCCUPIED, PRESETS, make_policy
from indoor_explorers.env.search.frontiers import frontier_mask
from indoor_explorers.env.sensing.rays import first_hits
from indoor_explorers.evaluation.exports.episodes.csv_tables import COLUMNS, write_csv
from indoor_explorers.evaluation.exports.episodes.moments import facts_of
from indoor_explorers.evaluation.exports.episodes.topics import RAYS, write_bag
from indoor_explorers.evaluation.harness.episodes.resimulate import resimulate
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from tests.evaluation.exports.episodes.reading import by_step, latest, messages

TALL = PRESETS["small-storeys"].for_evaluation().with_settings({"budget": 60})
POLICY = "frontier-nearest"


@pytest.fixture(scope="module")
def record():
    return next(iter(fly(make_policy(POLICY), POLICY, TALL, [Task(TALL.name, 0, 0)])))


@pytest.fixture(scope="module")
def topics(record, tmp_path_factory):
    folder = tmp_path_factory.mktemp("tall") / "tall"
    write_bag(record, TALL, folder, 1.0, mcap=True)
    return by_step(list(messages(folder / "tall.mcap")))


@pytest.fixture(scope="module")
def worlds(record):
    """The team's map, each UAV's, and the links, after every step."""
    return [
        (world.state.union[0].copy(), world.state.belief[0].copy(), world.state.linked[0].copy())
        for world in resimulate(record, TALL)
    ]


def metres(level, row, col):
    return col + 0.5, 24 - row - 0.5, level + 0.5


def voxels_of(cloud):
    """The (level, row, column) of the points of a cloud."""
    assert [(field.name, field.offset, field.datatype, field.count) for field in cloud.fields] == [
        ("x", 0, 7, 1),
        ("y", 4, 7, 1),
        ("z", 8, 7, 1),
    ]
    assert (cloud.height, cloud.point_step, cloud.row_step) == (1, 12, 12 * cloud.width)
    x, y, z = np.frombuffer(bytes(cloud.data), "<f4").reshape(-1, 3).T
    assert len(x) == cloud.width
    return set(zip((z - 0.5).tolist(), (23.5 - y).tolist(), (x - 0.5).tolist(), strict=True))


def test_maps_are_clouds_of_the_obstacles_of_all_levels(topics, worlds, record):
    volume = record.floorplan.levels.volume
    occupied = lambda plane: set(map(tuple, np.argwhere(volume(plane) == OCCUPIED).tolist()))  # noqa: E731
    assert voxels_of(topics["/true_map"][0]) == occupied(record.floorplan.truth)
    for step in (0, 13, record.steps):
        union, beliefs, _ = worlds[step]
        assert voxels_of(latest(topics["/map"], step)) == occupied(union)
        assert voxels_of(latest(topics["/uav_1/map"], step)) == occupied(beliefs[1])
    assert {voxel[0] for voxel in occupied(worlds[-1][0])} > {0, 3}


def test_poses_frames_and_paths_have_heights(topics, record):
    levels, heights = record.floorplan.levels, set()
    for step in range(record.steps + 1):
        for uav in range(record.team):
            place = topics[f"/uav_{uav}/pose"][step].pose.position
            there = metres(*levels.voxel(record.cells[step, uav]))
            assert (place.x, place.y, place.z) == there
            moved = topics["/tf"][step].transforms[uav].transform.translation
            assert (moved.x, moved.y, moved.z) == there
            heights.add(place.z)
    assert len(heights) > 2
    last = topics["/uav_0/path"][record.steps].poses[-1].pose.position
    assert (last.x, last.y, last.z) == metres(*levels.voxel(record.cells[-1, 0]))


def test_frontiers_links_and_scans_are_those_of_the_levels(topics, worlds, record):
    levels, linked = record.floorplan.levels, 0
    for step, (_, beliefs, links) in enumerate(worlds):
        points = latest(topics["/uav_0/frontiers"], step).markers[0].points
        cells = np.argwhere(frontier_mask(beliefs[0], levels.rise))
        assert [(p.x, p.y, p.z) for p in points] == [metres(*levels.voxel(cell)) for cell in cells]
        ends = latest(topics["/links"], step).markers[0].points
        assert len(ends) == 2 * links[0, 1]
        linked += len(ends) > 0 and ends[0].z != ends[1].z
        level, row, col = levels.voxel(record.cells[step, 0])
        truth = np.ascontiguousarray(levels.volume(record.floorplan.truth)[level])
        ranges = np.array(topics["/uav_0/scan"][step].ranges)
        np.testing.assert_allclose(ranges, first_hits(truth, (row, col), TALL.lidar.range, RAYS), rtol=1e-6)
    assert linked


def test_tables_have_levels_only_where_there_are_some(record, tmp_path):
    write_csv(record, TALL, tmp_path, 1.0)
    table = pd.read_csv(tmp_path / "steps.csv")
    assert [name for name in table.columns if name not in ("level", "z")] == list(COLUMNS)
    assert [*table.columns[3:9]] == ["level", "row", "col", "x", "y", "z"]
    voxels = record.floorplan.levels.voxels(record.cells).reshape(-1, 3)
    np.testing.assert_array_equal(table[["level", "row", "col"]], voxels)
    np.testing.assert_array_equal(table[["x", "y", "z"]], np.transpose(metres(*voxels.T)))
    assert table["level"].nunique() > 2
    told = json.loads((tmp_path / "meta.json").read_text())
    assert (told["levels"], told["rows"], told["columns"]) == (7, 24, 24)
    flat = PRESETS["thesis-team-4"].for_evaluation().with_settings({"budget": 3})
    plain = next(iter(fly(make_policy("random"), "random", flat, [Task(flat.name, 0, 0)])))
    assert "levels" not in facts_of(plain, 1.0)
