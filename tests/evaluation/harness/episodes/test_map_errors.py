"""Episodes whose maps and poses can be wrong, as the harness flies, measures, isolates and repeats them."""

import numpy as np
import pytest

from indoor_explorers.env import UNKNOWN, make_policy, scenario
from indoor_explorers.evaluation.harness.episodes.resimulate import ended_as_recorded, resimulate
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task

ROOM = (
    scenario("thesis-team-2")
    .for_evaluation()
    .with_settings({"budget": 120, "on_collision": "block", "map.height": 16, "map.width": 16})
)
ERRORS = {"noise.misses": 0.1, "noise.false_returns": 0.02, "drift.rate": 0.05, "lidar.field_of_view": 180.0}
OF_MAPS = {"map_error", "claimed", "pose_error"}


def flown(settings, policy="frontier-nearest", seeds=range(3)):
    task = ROOM.with_settings(settings)
    return task, list(fly(make_policy(policy), policy, task, [Task(task.name, 0, seed) for seed in seeds]))


@pytest.fixture(scope="module")
def erring():
    return flown(ERRORS)


def test_episodes_repeat_and_are_measured(erring):
    task, records = erring
    for record in records:
        assert not record.reason
        for world in resimulate(record, task):
            state = world.state
        assert ended_as_recorded(record, world)
        shown = state.union[0]
        wrong = ((shown != state.truth[0]) & (shown != UNKNOWN)).sum() / (shown != UNKNOWN).sum()
        assert record.metrics["map_error"] == pytest.approx(wrong)
        assert record.metrics["claimed"] >= record.covered[-1, 0] / record.reachable
        assert record.metrics["t99_to_bound"] is None
    assert max(record.metrics["pose_error"] for record in records) > 0.0
    assert max(record.metrics["map_error"] for record in records) > 0.0


def test_coverage_counts_what_is_shown_rightly_and_can_fall(erring):
    task, records = erring
    fell = False
    for record in records:
        for step, world in enumerate(resimulate(record, task)):
            state = world.state
            right = ((state.union[0] == state.truth[0]) & state.counts[0]).sum()
            assert record.covered[step, 0] == right
        fell |= bool((np.diff(record.covered[:, 0]) < 0).any())
    assert fell


def test_certain_worlds_have_no_such_measures():
    _, (record,) = flown({}, seeds=[0])
    assert not OF_MAPS & record.metrics.keys()
    assert record.metrics["t99_to_bound"] is not None


def test_a_limited_view_alone_leaves_maps_right_and_bounds_valid():
    _, records = flown({"lidar.field_of_view": 90.0})
    for record in records:
        assert record.metrics["map_error"] == 0.0
        assert record.metrics["claimed"] == pytest.approx(record.covered[-1, 0] / record.reachable)
        assert record.metrics["t99_to_bound"] >= 1.0
