"""Bags that explain: the markers, read back by another library, are what the pilots told after each step."""

from dataclasses import replace

import numpy as np
import pytest

from indoor_explorers.env import InputError, make_policy
from indoor_explorers.env.errors import RunError
from indoor_explorers.env.rendering.palette import uav_colours
from indoor_explorers.evaluation import export_episode
from indoor_explorers.evaluation.cli.parser import main
from indoor_explorers.evaluation.exports.episodes import export
from indoor_explorers.evaluation.exports.episodes.messages import HIGH, LOW
from indoor_explorers.evaluation.harness.episodes.flight import explained_again
from tests.evaluation.exports.episodes.reading import RESOLUTION, by_step, messages, record_of
from tests.evaluation.exports.episodes.test_bags import CHOICE, TOLD, metres, place


@pytest.fixture(scope="module")
def topics(folder, tmp_path_factory):
    path = export_episode(folder, tmp_path_factory.mktemp("told") / "hall.mcap", explanations=True, **CHOICE)
    return by_step(list(messages(path)))


@pytest.fixture(scope="module")
def told(results):
    record, scenario = record_of(results, *CHOICE.values())
    return list(explained_again(record, scenario, make_policy("frontier")))


def named(array, name):
    return [marker for marker in array.markers if marker.ns == name]


def colour_of(marker):
    return tuple(round(255 * getattr(marker.color, part)) for part in "rgb")


def test_every_change_is_a_message_that_begins_by_deleting_the_last_one(topics, told):
    for uav in range(3):
        mine, before = topics[f"/uav_{uav}/explanation"], None
        for step, each in enumerate(told, 1):
            assert (step in mine) == (each[uav] != before), (uav, step)
            before = each[uav]
        assert 0 not in mine
        assert all(array.markers[0].action == 3 for array in mine.values())
        assert {marker.header.frame_id for array in mine.values() for marker in array.markers} == {"map"}


def test_goal_way_and_candidates_are_where_the_pilot_says(topics, told):
    compared = 0
    for uav in range(3):
        for step, array in topics[f"/uav_{uav}/explanation"].items():
            mine = told[step - 1][uav]
            assert len({(m.ns, m.id) for m in array.markers}) == len(array.markers)
            ways, goals, spheres = (named(array, name) for name in ("way", "goal", "candidates"))
            assert [[place(point) for point in way.points] for way in ways] == [
                [metres(cell) for cell in mine.path] for _ in range(len(mine.path) > 1)
            ]
            assert [place(goal.pose.position) for goal in goals] == [metres(mine.goal)] * (mine.goal is not None)
            assert [place(each.pose.position) for each in spheres] == [metres(each.cell) for each in mine.candidates]
            assert {marker.type for marker in spheres} <= {2}
            assert {colour_of(marker) for marker in (*ways, *goals)} <= {tuple(uav_colours(3)[uav].tolist())}
            texts = [each.text for each in named(array, "scores")]
            assert texts == [f"{rank}: {each.score:.3g}" for rank, each in enumerate(mine.candidates, 1)]
            said = [each.text for each in named(array, "goal text")]
            assert said == [] if mine.goal is None else f"chosen at step {mine.step}" in said[0]
            compared += len(spheres)
    assert compared > 50


def test_colours_go_from_the_lowest_score_to_the_highest(topics):
    seen = 0
    for array in topics["/uav_0/explanation"].values():
        shades = [colour_of(each) for each in named(array, "candidates")]
        if len(shades) > 1:
            assert (shades[0], shades[-1]) == (HIGH, LOW)
            seen += 1
        assert all(0 < each.scale.x <= RESOLUTION for each in named(array, "candidates"))
    assert seen > 3


def test_the_rest_of_the_bag_is_as_without_explanations(folder, topics, tmp_path):
    plain = by_step(list(messages(export_episode(folder, tmp_path / "plain.mcap", **CHOICE))))
    assert set(topics) - set(plain) == {f"/uav_{uav}/explanation" for uav in range(3)}
    assert {name: list(held) for name, held in plain.items()} == {name: list(topics[name]) for name in plain}
    assert TOLD["/uav_N/explanation"] == "visualization_msgs/msg/MarkerArray"


def test_the_command_has_an_option_and_an_sqlite_bag_has_the_same(folder, topics, tmp_path, capsys):
    words = ["export", str(folder), "--policy", "frontier", "--map", "hall", "--seed", "1", "--format", "rosbag2"]
    assert main([*words, "--explanations", "--out", str(tmp_path / "bag")]) == 0
    found = by_step(list(messages(tmp_path / "bag")))
    assert {step: len(array.markers) for step, array in found["/uav_1/explanation"].items()} == {
        step: len(array.markers) for step, array in topics["/uav_1/explanation"].items()
    }


def test_what_cannot_be_explained_is_told_and_nothing_is_written(folder, results, tmp_path, monkeypatch):
    out = tmp_path / "a.mcap"
    with pytest.raises(InputError, match="expected explanations in mcap or rosbag2, got csv"):
        export_episode(folder, tmp_path / "csv", format="csv", explanations=True, **CHOICE)
    record, _ = record_of(results, *CHOICE.values())
    other = replace(record, actions=np.where(record.actions == 0, 2, 0).astype(np.uint8))
    with pytest.raises(RunError, match=r"frontier cannot be explained: flown again, it .*; leave out --explanations"):
        next(export._told(results, other))
    monkeypatch.setattr(export, "policy_again", _refuse)
    with pytest.raises(InputError, match="frontier cannot be explained: not here; leave out --explanations"):
        export_episode(folder, out, explanations=True, **CHOICE)
    assert list(tmp_path.iterdir()) == []


def _refuse(*_):
    raise InputError("not here")
