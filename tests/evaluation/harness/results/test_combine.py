"""Results of several stores as one: what is alike is joined, what differs is named."""

from dataclasses import replace

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, InputError
from indoor_explorers.env.maps.sources import FileMaps
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.combine import combined
from indoor_explorers.evaluation.harness.results.policy_version import differing_fields
from indoor_explorers.evaluation.harness.results.results import Results
from tests.evaluation.plugins import Wander

FACTS = {"use": "wander", "class": "plugins:Wander", "privileged": False, "parameters": {"speed": "1"}, "hash": "a"}


def flown(task=None, policies=("w",), seeds=range(3), name=None, run=None, **settings):
    """What a store would hold after these policies flew these seeds."""
    task = (task or PRESETS["thesis-team-2"]).for_evaluation().with_settings(settings)
    records = [
        record
        for policy in policies
        for record in fly(
            Wander(), policy, task, [Task(task.name, index, s) for index in range(task.map.count) for s in seeds]
        )
    ]
    about = {policy: dict(FACTS) for policy in policies}
    held = {task.name: {"fingerprint": task.fingerprint, **task.model_dump(mode="json")}}
    return Results(about, held, [{"commit": "c0", "numpy version": "2.3"} | (run or {})], records)


@pytest.fixture(scope="module")
def one():
    return flown()


def refusal(*parts):
    with pytest.raises(InputError) as caught:
        combined(parts)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def changed(results, which=0, **fields):
    records = list(results.records)
    records[which] = replace(records[which], **fields)
    return replace(results, records=records, runs=[{"commit": "c1"}])


def test_policies_on_the_same_tasks_are_joined(one):
    other = flown(policies=("w", "v"))
    both = combined([one, other, flown(PRESETS["thesis-open"], policies=("w",), seeds=range(9))])
    assert list(both.policies) == ["w", "v"]
    assert list(both.scenarios) == ["thesis-team-2", "thesis-open"]
    assert [len(records) for records in both.groups.values()] == [3, 3, 9]
    assert combined([one]) is one


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"radio.range": 1.0}, "what differs: radio.range (3.0 and 1.0)"),
        ({"lidar.range": 5, "budget": 90}, "what differs: lidar.range (3.0 and 5.0), budget (400 and 90)"),
        ({"map.obstacles": 7}, "map.obstacles (5 and 7); the cells of map 0, seed 0"),
        ({"team": 3}, "team (2 and 3)"),
        ({"spawn": "clustered"}, "spawn (random and clustered); the starts of map 0, seed 0"),
    ],
)
def test_scenarios_that_differ_are_refused_by_their_fields(settings, words, one):
    message = refusal(one, flown(**settings))
    assert message.startswith("scenario 'thesis-team-2' is not the same task in both results; ")
    assert words in message


def test_maps_that_differ_in_their_cells_alone_are_refused(tmp_path):
    rows = np.zeros((12, 12), bool)
    for folder, column in (("a", 4), ("b", 6), ("c", 4)):
        (tmp_path / folder).mkdir()
        walls = rows.copy()
        walls[:9, column] = True
        np.save(tmp_path / folder / "floor.npy", walls.astype(np.uint8))
    office = PRESETS["office"]
    results = [
        flown(office.model_copy(update={"map": FileMaps(paths=(str(tmp_path / folder / "floor.npy"),))}), budget=30)
        for folder in "abc"
    ]
    assert "what differs: the cells of map 0, seed 0" in refusal(results[0], results[1])
    assert len(combined([results[0], results[2]]).records) == 3  # where a file lies does not matter


def test_maps_that_one_commit_drew_otherwise_are_refused(one):
    turned = replace(one.records[1].floorplan, truth=one.records[1].floorplan.truth.T.copy())
    assert "what differs: the cells of map 0, seed 1" in refusal(one, changed(one, 1, floorplan=turned))


def test_other_seeds_are_refused(one):
    message = refusal(one, flown(seeds=range(1, 3)))
    assert "not flown on the same seeds in both results (0 to 2, 3 tasks and 1 to 2, 2 tasks)" in message


@pytest.mark.parametrize(
    ("facts", "words"),
    [
        ({"parameters": {"speed": "2"}, "hash": "b"}, "what differs: parameters.speed (1 and 2); rename it"),
        ({"weights_sha256": "9f" * 32, "hash": "b"}, "what differs: weights_sha256 (not set and 9f9f9f"),
    ],
)
def test_policies_of_one_name_that_differ_are_refused(facts, words, one):
    assert words in refusal(one, replace(one, policies={"w": FACTS | facts}))


def test_unlike_flights_of_one_policy_are_refused_with_the_commits(one):
    record = one.records[2]
    message = refusal(one, changed(one, 2, covered=record.covered - 1))
    assert "policy 'w' flew scenario 'thesis-team-2', map 0, seed 2 differently" in message
    assert "at commit c0" in message
    assert "at commit c1" in message
    assert "differently" in refusal(one, changed(one, 0, actions=one.records[0].actions[::-1]))
    assert len(combined([one, changed(one, 2, seconds=record.seconds + 1)]).records) == 3  # time is the machine's


def test_versions_that_differ_are_warned_of_and_not_refused(one):
    other = flown(policies=("v",), run={"numpy version": "2.4", "commit": "c0", "processor": "Z80", "workers": 9})
    assert one.warnings == []
    assert combined([one, other]).warnings == [
        "runs differ in numpy version: 2.3, 2.4",
        "runs differ in processor: not recorded, Z80; latencies do not compare",
    ]


def test_many_and_long_differences_stay_readable():
    text = differing_fields({f"a{k}": k for k in range(20)} | {"b": "x" * 500}, {})
    assert text.endswith("and 13 more")
    assert "…" in differing_fields({"b": "x" * 500}, {"b": 1})
