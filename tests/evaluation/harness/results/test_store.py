"""The store: round trip, growth, refusal of another experiment."""

import resource
import sqlite3
from dataclasses import replace

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, InputError
from indoor_explorers.env.errors import RunError
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.evaluation.harness.episodes.record import Outcome
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task, build_experiment
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.harness.results.database import not_written
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.harness.results.store import Store
from tests.evaluation.plugins import Wander

POLICY = "tests.evaluation.plugins:Wander"


def experiment(**changes):
    settings = {"policies": [{"use": POLICY, "name": "w"}], "scenarios": [PRESETS["thesis-team-2"]]}
    settings |= {"episodes": 3, "seed": 5, "settings": {}} | changes
    settings["scenarios"] = [scenario.for_evaluation() for scenario in settings["scenarios"]]
    return build_experiment(**settings)


def about(planned):
    return {choice.name: {"use": choice.use, "privileged": False} for choice in planned.policies}


def filled(path):
    planned = experiment()
    with Store(path) as store:
        run = store.begin_run(planned, about(planned), {"command": "x"})
        records = list(fly(Wander(), "w", planned.scenarios[0], planned.tasks()))
        for record in records:
            store.add(record, run)
            store.add(record, run)
    return records


def test_what_goes_in_comes_out(tmp_path):
    records = filled(tmp_path / "results.db")
    with Store(tmp_path / "results.db") as store:
        again = list(store.records())
        assert store.finished() == {("w", Task("thesis-team-2", 0, seed)) for seed in (5, 6, 7)}
        assert store.runs() == [{"command": "x"}]
    for record, copy in zip(records, again, strict=True):
        np.testing.assert_array_equal(record.covered, copy.covered)
        np.testing.assert_array_equal(record.cells, copy.cells)
        np.testing.assert_array_equal(record.actions, copy.actions)
        np.testing.assert_array_equal(record.seconds, copy.seconds)
        np.testing.assert_array_equal(record.sent, copy.sent)
        np.testing.assert_array_equal(record.floorplan.truth, copy.floorplan.truth)
        assert record.metrics == copy.metrics
        assert (record.task, record.outcome, record.steps) == (copy.task, copy.outcome, copy.steps)


def test_a_store_from_before_a_derived_fact_goes_on_and_learns_it(tmp_path):
    filled(tmp_path / "results.db")
    planned = experiment()
    facts = {name: each | {"uses_generator": True} for name, each in about(planned).items()}
    with Store(tmp_path / "results.db") as store:
        assert store.begin_run(planned, facts, {"command": "y"}) == 2
        assert store.policies() == facts
        other = {name: each | {"use": "another"} for name, each in facts.items()}
        with pytest.raises(InputError, match="holds episodes flown by another version of a policy"):
            store.begin_run(planned, other, {"command": "z"})


def test_floor_plans_are_read_back_whole(tmp_path):
    marked = Floorplan.from_free(np.ones((5, 7), np.bool_), "marked", 0.25, 0.5, (4, 6))
    record = filled(tmp_path / "results.db")[0]
    with Store(tmp_path / "results.db") as store:
        store.add(replace(record, floorplan=marked, task=record.task._replace(seed=99)), 1)
        plans = [copy.floorplan for copy in store.records()]
    assert [plan.digest for plan in plans[:-1]].count(record.floorplan.digest) == 1
    assert (plans[0].start, plans[-1].digest, plans[-1].start) == (None, marked.digest, (4, 6))
    assert (plans[-1].name, plans[-1].resolution, plans[-1].kept) == ("marked", 0.25, 0.5)


def test_the_map_of_a_task_is_given_once(tmp_path):
    planned = experiment(policies=[{"use": POLICY, "name": name} for name in "wv"])
    (record,) = fly(Wander(), "w", planned.scenarios[0], planned.tasks()[:1])
    other = replace(record, policy="v").without_map()
    with Store(tmp_path / "results.db") as store:
        run = store.begin_run(planned, about(planned), {})
        with pytest.raises(KeyError):
            store.add(other, run)
        for each in (record, other):
            store.add(each, run)
        assert [(r.policy, r.floorplan.digest) for r in store.records()] == [(n, record.floorplan.digest) for n in "wv"]


def test_an_experiment_may_grow(tmp_path):
    filled(tmp_path / "results.db")
    grown = experiment(episodes=5, policies=[{"use": POLICY, "name": "w"}, {"use": POLICY, "name": "v"}])
    with Store(tmp_path / "results.db") as store:
        store.begin_run(grown, about(grown), {})
        assert list(store.policies()) == ["w", "v"]
        assert store.runs() == [{"command": "x"}]  # the second one has flown nothing yet


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"seed": 6}, r"seed \(5 there, 6 here\)"),
        ({"scenarios": [PRESETS["thesis-open"]]}, r"scenarios \(thesis-team-2 there, thesis-open here\)"),
        ({"settings": {"radio.range": 1.0}}, "the settings of scenario 'thesis-team-2'"),
    ],
)
def test_another_experiment_is_refused(changes, message, tmp_path):
    filled(tmp_path / "results.db")
    other = experiment(**changes)
    with Store(tmp_path / "results.db") as store, pytest.raises(InputError, match=message):
        store.begin_run(other, about(other), {})


def test_other_parameters_of_a_policy_are_refused(tmp_path):
    filled(tmp_path / "results.db")
    planned = experiment()
    with Store(tmp_path / "results.db") as store, pytest.raises(InputError, match="policy 'w': privileged"):
        store.begin_run(planned, {"w": {"use": POLICY, "privileged": True}}, {})


def test_a_parameter_that_was_added_since_has_its_default_in_older_results(tmp_path):
    filled(tmp_path / "results.db")
    planned = experiment()
    added = {"parameters": {"speed": "1"}, "defaults": {"speed": "1"}, "hash": "another"}
    changed = {"parameters": {"speed": "2"}, "defaults": {"speed": "1"}}
    with Store(tmp_path / "results.db") as store:
        assert store.begin_run(planned, {name: facts | added for name, facts in about(planned).items()}, {}) == 2
        with pytest.raises(InputError, match=r"policy 'w': parameters.speed \(1 and 2\)"):
            store.begin_run(planned, {name: facts | changed for name, facts in about(planned).items()}, {})


def test_a_parameter_that_was_renamed_since_has_its_old_name_in_older_results(tmp_path):
    planned = experiment()
    with Store(tmp_path / "results.db") as store:
        before = {
            "parameters": {"fast": "2", "inside": "{'b': 3, 'a': 1}"},
            "defaults": {"fast": "1"},
            "hash": "another",
        }
        store.begin_run(planned, {name: facts | before for name, facts in about(planned).items()}, {})
        store.add(filled(tmp_path / "other.db")[0], 1)
        renamed = {"fast": ["speed", "pace"], "inside.b": ["inside.c"]}
        now = {"speed": "2", "pace": "2", "inside": "{'a': 1, 'c': 3}"}
        same = {"parameters": now, "defaults": {"speed": "1", "pace": "1"}, "renamed": renamed}
        assert store.begin_run(planned, {name: facts | same for name, facts in about(planned).items()}, {}) == 2
        for other, what in (
            ({"speed": "1"}, r"speed \(2 and 1\)"),
            ({"inside": "{'a': 1, 'c': 4}"}, r"inside.c \(3 and 4\)"),
        ):
            changed = same | {"parameters": now | other}
            with pytest.raises(InputError, match=rf"policy 'w': parameters.{what}"):
                store.begin_run(planned, {name: facts | changed for name, facts in about(planned).items()}, {})


def test_of_many_differences_a_few_are_named(tmp_path):
    planned = experiment(policies=[{"use": POLICY, "name": f"p{n}"} for n in range(9)])
    record = filled(tmp_path / "other.db")[0]
    with Store(tmp_path / "results.db") as store:
        store.begin_run(planned, about(planned), {})
        for policy in planned.policies:
            store.add(replace(record, policy=policy.name), 1)
        others = {name: facts | {"privileged": True} for name, facts in about(planned).items()}
        with pytest.raises(InputError, match=r"policy 'p0': .*'p3': [^;]*; and 5 more; fly them again"):
            store.begin_run(planned, others, {})


def test_a_full_disk_is_said_and_what_was_added_stays(tmp_path):
    planned = experiment(episodes=40)
    records = list(fly(Wander(), "w", planned.scenarios[0], planned.tasks()))

    def add_all(store):
        for record in records:
            store.add(record, 1)

    with Store(tmp_path / "results.db") as store:
        store.begin_run(planned, about(planned), {})
        store._db.execute("PRAGMA max_page_count = 30")
        with pytest.raises(RunError, match="database or disk is full; the finished episodes are kept: make room"):
            add_all(store)
        kept = store.finished()
        assert 0 < len(kept) < 40
    with Store(tmp_path / "results.db") as store:
        assert store.finished() == kept
        add_all(store)
        assert len(list(store.records())) == 40


def test_a_limit_of_files_is_named(monkeypatch, tmp_path):
    monkeypatch.setattr(resource, "getrlimit", lambda which: (4096, 4096) if which == resource.RLIMIT_FSIZE else None)
    assert "kept: raise the limit of 4096 bytes a file (ulimit -f), or make room on" in str(
        not_written(tmp_path, OSError())
    )


@pytest.mark.parametrize(
    ("reason", "replaced"),
    [
        ("the process of the policy was killed by signal 9 (SIGKILL)", True),
        ("worker used more than 2 GB of memory (--memory-limit)", True),
        ("the process of the policy was killed by signal 11 (SIGSEGV)", False),
        ("RuntimeError: motor failure", False),
        ("no decision within 60 s", False),
    ],
)
def test_only_failures_of_the_machine_are_replaced_and_every_retry_is_kept(reason, replaced, tmp_path):
    good = filled(tmp_path / "results.db")[0]
    failed = replace(good, outcome=Outcome.FAILED, reason=reason, task=good.task._replace(seed=99))
    other = {"actions": good.actions[:1], "covered": good.covered[:2], "cells": good.cells[:2]}
    other |= {"seconds": good.seconds[:2], "sent": good.sent[:2]}
    with Store(tmp_path / "results.db") as store:
        store.add(failed, 1)
        assert len(store.finished()) == len(store.finished(failed=False)) + 1
        for record in (good, replace(failed, outcome=Outcome.BUDGET)):
            store.add(replace(record, **other), 1)
        assert all(copy.steps > 1 for copy in store.records())
        assert store.retries() == {}
        for record in (good, replace(failed, outcome=Outcome.BUDGET)):
            store.add(replace(record, **other), 1, replace_failed=True)
        steps = {copy.task.seed: copy.steps for copy in store.records()}
        assert (steps.pop(99) == 1) is replaced
        assert min(steps.values()) > 1
        assert (store.finished() == store.finished(failed=False)) is replaced
        assert store.retries() == {("w", failed.task): 1}
    results = Results.load(tmp_path)
    assert results.warnings[0].startswith(
        "episodes flown again after a failure: 1 of w; the first attempt counts where"
    )
    assert results.episodes()["retries"].tolist() == [0, 0, 0, 1]


def test_a_file_that_is_no_store_is_refused(tmp_path):
    (tmp_path / "results.db").write_text("not a database at all, but long enough to be one of the pages" * 20)
    with pytest.raises(InputError, match="expected a results store"):
        Store(tmp_path / "results.db")
    sqlite3.connect(tmp_path / "other.db").execute("CREATE TABLE meta (key, value)").connection.close()
    with pytest.raises(InputError, match="expected a store of format 3"):
        Store(tmp_path / "other.db")


def test_what_all_runs_flew_is_one_experiment(tmp_path):
    filled(tmp_path / "results.db")
    other = experiment(episodes=2, policies=[{"use": POLICY, "name": "v, w", "parameters": {"speed": 3}}])
    with Store(tmp_path / "results.db") as store:
        store.begin_run(other, about(other), {})
        (tmp_path / "all.toml").write_text(store.experiment())
    planned = plan(ComparisonRequest(experiment=tmp_path / "all.toml"))
    assert [choice.name for choice in planned.policies] == ["w", "v, w"]
    assert planned.policies[1] == other.policies[0]
    assert (planned.scenarios, planned.episodes, planned.seed) == (other.scenarios, 3, 5)
