"""Bags hold what happened in the episode: read back by another library, and compared field by field."""

import json
import math
import re

import numpy as np
import pytest
import yaml
from mcap.reader import make_reader

from indoor_explorers.env import FREE, OCCUPIED, PRESETS, UNKNOWN
from indoor_explorers.env.sensing.lidar import scan
from indoor_explorers.evaluation import export_episode
from indoor_explorers.evaluation.exports.episodes.topics import write_bag
from indoor_explorers.evaluation.harness.episodes.resimulate import resimulate
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from tests.documents import SITE
from tests.evaluation.exports.episodes.reading import RESOLUTION, SECOND, SHAPE, by_step, latest, messages, record_of
from tests.evaluation.plugins import Wander, Wanderer

CHOICE = {"policy": "frontier", "map": "hall", "seed": 1}
#: The topics of the guide with their types.
TOLD = dict(re.findall(r"^\| `(/\S+)` \| `(\S+)` \|", (SITE / "pages/guides/ros.md").read_text(), re.MULTILINE))


@pytest.fixture(scope="module")
def path(folder, tmp_path_factory):
    return export_episode(folder, tmp_path_factory.mktemp("bag") / "hall.mcap", **CHOICE)


@pytest.fixture(scope="module")
def found(path):
    return list(messages(path))


@pytest.fixture(scope="module")
def topics(found):
    return by_step(found)


@pytest.fixture(scope="module")
def record(results):
    return record_of(results, *CHOICE.values())[0]


@pytest.fixture(scope="module")
def worlds(results):
    """What the UAVs knew after every step: beliefs, union, links, and their component."""
    record, scenario = record_of(results, *CHOICE.values())
    held = []
    for step, world in enumerate(resimulate(record, scenario)):
        state = world.state
        heard = state.last_received_step[0] == step
        held.append((state.belief[0].copy(), state.union[0].copy(), state.linked[0].copy(), heard))
    return held


def belief_of(grid):
    """The belief that a grid says, cell by cell: its data begin at the lower left."""
    value = {-1: UNKNOWN, 0: FREE, 100: OCCUPIED}
    belief = np.empty((grid.info.height, grid.info.width), np.uint8)
    for row in range(grid.info.height):
        for col in range(grid.info.width):
            belief[row, col] = value[grid.data[(grid.info.height - 1 - row) * grid.info.width + col]]
    return belief


def metres(cell):
    """The centre of a cell (row, column)."""
    return (cell[1] + 0.5) * RESOLUTION, (SHAPE[0] - cell[0] - 0.5) * RESOLUTION


def place(point):
    return point.x, point.y


def test_topics_and_their_types_are_those_of_the_guide(found):
    numbers = {f"/uav_{uav}/heard/uav_{mate}": "/uav_N/heard/uav_M" for uav in range(3) for mate in range(3)}
    kinds = {(numbers.get(m.topic) or re.sub(r"uav_\d", "uav_N", m.topic), m.kind) for m in found}
    assert kinds == {pair for pair in TOLD.items() if not pair[0].endswith("/explanation")}
    assert {m.topic for m in found if "heard" in m.topic} == {name for name in numbers if name[5] != name[-1]}


def test_both_storages_hold_the_same_messages(folder, found, tmp_path, record):
    bag = export_episode(folder, tmp_path / "hall", format="rosbag2", **CHOICE)
    assert [m[:4] for m in messages(bag)] == [m[:4] for m in found]
    told = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert (told["message_count"], told["relative_file_paths"]) == (len(found), ["hall.db3"])
    assert told["duration"]["nanoseconds"] == record.steps * SECOND
    about = json.loads(told["custom_data"]["episode"])
    assert (about["policy"], about["map"], about["seed"]) == ("frontier", "hall", 1)
    assert (about["steps"], about["outcome"]) == (record.steps, str(record.outcome))


def test_an_mcap_file_has_an_index(path, found):
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary.statistics.message_count == len(found)
    assert {chunk.compression for chunk in summary.chunk_indexes} == {"zstd"}


def test_stamps_grow_and_headers_agree(found, record):
    stamps = [message.stamp for message in found]
    assert stamps == sorted(stamps)
    assert (stamps[0], stamps[-1]) == (SECOND, SECOND + record.steps * SECOND)
    for message in found:
        headers = [message.content.header] if hasattr(message.content, "header") else []
        headers += [each.header for each in getattr(message.content, "markers", [])]
        headers += [each.header for each in getattr(message.content, "transforms", [])]
        for header in headers:
            assert header.stamp.sec * SECOND + header.stamp.nanosec == message.stamp
            assert header.frame_id == ("uav_" + message.topic[5] if message.topic.endswith("/scan") else "map")


def test_grids_are_the_beliefs_cell_by_cell(topics, worlds, record):
    np.testing.assert_array_equal(belief_of(topics["/true_map"][0]), record.floorplan.truth)
    for name, which in [("/map", lambda w: w[1]), *((f"/uav_{n}/map", lambda w, n=n: w[0][n]) for n in range(3))]:
        before = None
        for step, world in enumerate(worlds):
            known = which(world)
            if before is None or not np.array_equal(known, before):
                grid = topics[name][step]
                np.testing.assert_array_equal(belief_of(grid), known)
                assert (grid.info.width, grid.info.height) == SHAPE[::-1]
                assert grid.info.resolution == pytest.approx(RESOLUTION)
                assert (*place(grid.info.origin.position), grid.info.origin.orientation.w) == (0.0, 0.0, 1.0)
            else:
                assert step not in topics[name]
            before = known.copy()


@pytest.mark.parametrize("policy", ["frontier", "frontier-nearest"])
@pytest.mark.parametrize(("map", "seed"), [("hall", 0), ("room", 1)])
def test_the_last_grid_of_the_team_is_its_final_map(folder, results, tmp_path, policy, map, seed):
    path = export_episode(folder, tmp_path / "a.mcap", policy=policy, map=map, seed=seed)
    record, scenario = record_of(results, policy, map, seed)
    *_, world = resimulate(record, scenario)
    team = belief_of(by_step(list(messages(path)))["/map"].popitem()[1])
    np.testing.assert_array_equal(team, world.state.union[0])
    assert np.count_nonzero((team != UNKNOWN) & world.state.counts[0]) == record.covered[-1, 0]


def test_poses_and_frames_are_the_cells(topics, record):
    for step in range(record.steps + 1):
        transforms = {each.child_frame_id: each.transform for each in topics["/tf"][step].transforms}
        for uav, cell in enumerate(record.cells[step].tolist()):
            pose, moved = topics[f"/uav_{uav}/pose"][step].pose, transforms[f"uav_{uav}"]
            assert place(pose.position) == place(moved.translation) == metres(cell)
            assert (pose.orientation.w, moved.rotation.w) == (1.0, 1.0)


def test_a_path_has_a_pose_for_each_cell_flown(topics, record):
    for uav in range(3):
        for step, path in topics[f"/uav_{uav}/path"].items():
            cells = record.cells[: step + 1, uav].astype(int)
            flown = np.abs(np.diff(cells, axis=0)).sum()
            assert len(path.poses) == 1 + flown
            assert place(path.poses[0].pose.position) == metres(cells[0])
            assert place(path.poses[-1].pose.position) == metres(cells[-1])
            stamps = [each.header.stamp.sec for each in path.poses]
            assert stamps == sorted(set(stamps))
        assert max(topics[f"/uav_{uav}/path"]) == record.steps


def test_scans_say_what_the_lidar_sees(topics, record):
    for step in range(0, record.steps + 1, 7):
        cell = tuple(record.cells[step, 0].tolist())
        told = topics["/uav_0/scan"][step]
        ranges = np.array(told.ranges)
        assert len(ranges) == round((told.angle_max - told.angle_min) / told.angle_increment) + 1 == 360
        assert (told.range_min, told.range_max) == (0.0, 4.0 * RESOLUTION)
        assert ((ranges <= told.range_max) | np.isinf(ranges)).all()
        for index in np.flatnonzero(np.isfinite(ranges)):
            angle, beyond = told.angle_min + index * told.angle_increment, ranges[index] / RESOLUTION + 1e-4
            x, y = beyond * math.cos(angle), beyond * math.sin(angle)
            hit = math.floor(cell[0] + 0.5 - y), math.floor(cell[1] + 0.5 + x)
            assert record.floorplan.truth[hit] == OCCUPIED
        seen = scan(record.floorplan.truth, cell, 4.0)
        for angle, way in ((-180, (0, -1)), (-90, (1, 0)), (0, (0, 1)), (90, (-1, 0))):
            clear = next((k for k in range(1, 5) if seen[cell[0] + k * way[0], cell[1] + k * way[1]] != FREE), 5)
            expected = (clear - 0.5) * RESOLUTION if clear <= 4 else math.inf
            assert ranges[angle + 180] == pytest.approx(expected)


def test_frontiers_are_free_cells_beside_unknown_ones(topics, worlds):
    for uav in range(3):
        for step, array in topics[f"/uav_{uav}/frontiers"].items():
            belief = worlds[step][0][uav]
            around = np.pad(belief, 1, constant_values=FREE)
            beside = [around[1 + d : 1 + d + SHAPE[0], 1 + r : 1 + r + SHAPE[1]] for d, r in ((1, 0), (-1, 0))]
            beside += [around[1:-1, 1 + r : 1 + r + SHAPE[1]] for r in (1, -1)]
            mask = (belief == FREE) & np.any([part == UNKNOWN for part in beside], axis=0)
            (marker,) = array.markers
            assert {place(point) for point in marker.points} == {metres(cell) for cell in np.argwhere(mask)}
            assert (marker.type, marker.action) == (6, 0 if mask.any() else 2)


def test_links_join_the_uavs_in_contact(topics, worlds, record):
    lengths = set()
    for step, (*_, linked, _) in enumerate(worlds):
        (marker,) = latest(topics["/links"], step).markers
        ends = [place(point) for point in marker.points]
        pairs = [(i, j) for i, j in np.argwhere(linked) if i < j]
        assert ends == [metres(record.cells[step, uav]) for pair in pairs for uav in pair]
        assert (marker.type, marker.action) == (5, 0 if pairs else 2)
        lengths.add(len(pairs))
    assert len(lengths) > 1


def test_a_uav_hears_the_poses_of_those_it_is_connected_with(topics, worlds, record):
    for step, (*_, heard) in enumerate(worlds):
        for uav, mate in np.argwhere(~np.eye(3, dtype=bool)).tolist():
            message = topics[f"/uav_{uav}/heard/uav_{mate}"].get(step)
            assert (message is not None) == heard[uav, mate]
            if message is not None:
                assert place(message.pose.position) == metres(record.cells[step, mate])


def test_coverage_is_the_recorded_curve(topics, record):
    told = [topics["/coverage"][step].data for step in range(record.steps + 1)]
    np.testing.assert_allclose(told, record.curve, rtol=1e-12)


class Careless(Wanderer):
    """Fly at random, into walls too."""

    def act(self, view):
        return int(self.rng.integers(4))


class CarelessPolicy(Wander):
    def pilot(self, briefing):
        return Careless(briefing)


def test_uavs_that_have_ended_are_silent(tmp_path):
    scenario = PRESETS["thesis-team-4"].for_evaluation().with_settings({"on_collision": "end", "budget": 200})
    (record,) = fly(CarelessPolicy(), "careless", scenario, [Task(scenario.name, 0, 3)])
    write_bag(record, scenario, tmp_path / "bag", 1.0, mcap=False)
    topics = by_step(list(messages(tmp_path / "bag")))
    flying = np.array([world.flying[0].copy() for world in resimulate(record, scenario)])
    ends = np.argmin(flying, axis=0).tolist()
    assert len(set(ends)) > 1
    for uav, last in enumerate(ends):
        assert max(topics[f"/uav_{uav}/pose"]) == max(topics[f"/uav_{uav}/scan"]) == last
    assert len(topics["/tf"][record.steps].transforms) == ends.count(record.steps)


def test_poses_that_drift_are_those_that_uavs_believe(tmp_path):
    scenario = (
        PRESETS["thesis-team-2"]
        .for_evaluation()
        .with_settings({"on_collision": "block", "budget": 40, "drift.rate": 0.3, "radio.model": "unlimited"})
    )
    (record,) = fly(Wander(), "wander", scenario, [Task(scenario.name, 0, 3)])
    write_bag(record, scenario, tmp_path / "bag", 1.0, mcap=False)
    topics, apart = by_step(list(messages(tmp_path / "bag"))), 0
    for step, world in enumerate(resimulate(record, scenario)):
        state = world.state
        for uav, (row, col) in enumerate(state.believed_cell[0].tolist()):
            where = (col + 0.5, 16 - row - 0.5)
            assert place(topics[f"/uav_{uav}/pose"][step].pose.position) == where
            assert place(topics[f"/uav_{1 - uav}/heard/uav_{uav}"][step].pose.position) == where
            apart += (row, col) != tuple(state.cell[0, uav].tolist())
    assert apart > 10
