"""Episodes with a home base, or with UAVs that stop: what is recorded, stored, reported and simulated again."""

import numpy as np
import pytest

from indoor_explorers.env import make_policy, scenario
from indoor_explorers.evaluation.exports.episodes.moments import moments
from indoor_explorers.evaluation.harness.episodes.metrics import OF_BASE
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.report.replay.packed_episode import resimulated

BASE = {"base.at": "start", "radio.model": "disc", "radio.range": 4.0, "on_collision": "block", "budget": 120}


def flown(settings, policy="frontier-minpos", seeds=(1, 2, 3)):
    task = scenario("thesis-team-4").for_evaluation().with_settings(settings)
    return task, list(fly(make_policy(policy), policy, task, [Task(task.name, 0, seed) for seed in seeds]))


def test_both_curves_are_recorded_and_either_may_count():
    (_, seen), (task, returned) = flown(BASE), flown(BASE | {"base.must_return": True})
    for one, other in zip(seen, returned, strict=True):
        assert one.covered.shape[1] == other.covered.shape[1] == 1 + 4 + 2
        assert np.array_equal(one.curve, one.coverage("seen"))
        assert np.array_equal(other.curve, other.coverage("base"))
        assert (other.coverage("base") <= other.coverage("seen")).all()
        short = one.steps + 1  # the same flight, until what is seen is all
        assert np.array_equal(one.coverage("base"), other.coverage("base")[:short])
        assert other.metrics["t99"] == other.metrics["t99_base"]
        assert other.metrics["unreported"] == pytest.approx(other.coverage("seen")[-1] - other.coverage("base")[-1])
        assert other.metrics["auc_base"] == other.metrics["auc"] < other.metrics["auc_seen"]
        assert resimulated(other, task).faithful
        assert len(list(moments(other, task))) == other.steps + 1


def test_without_a_base_there_are_no_such_metrics():
    _, (record, *_) = flown({})
    assert not {*OF_BASE, "stopped"} & record.metrics.keys()
    assert record.covered.shape[1] == 1 + 4


def test_coverage_may_fall_where_uavs_stop_and_everything_agrees():
    task, records = flown({"failures.hazard": 0.02, "radio.model": "none"}, seeds=range(12))
    assert any((np.diff(record.curve) < 0).any() for record in records)
    assert {record.metrics["stopped"] for record in records} >= {1.0, 4.0}
    assert all(resimulated(record, task).faithful for record in records)
