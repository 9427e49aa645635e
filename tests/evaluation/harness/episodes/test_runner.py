"""Episodes flown by the runner."""

import numba
import numpy as np
import pytest
from numba.core import event

from indoor_explorers.env import PRESETS
from indoor_explorers.evaluation.harness.episodes.metrics import OF_THE_MACHINE
from indoor_explorers.evaluation.harness.episodes.record import AXES, Outcome
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from tests.evaluation.plugins import Batched, Raises, Wander, Wanderer, WrongAction

TEAM = PRESETS["thesis-team-2"].for_evaluation()


def tasks(count, start=0):
    return [Task(TEAM.name, 0, seed) for seed in range(start, start + count)]


def facts(record):
    kept = {name: value for name, value in record.metrics.items() if name not in OF_THE_MACHINE}
    return record.task, record.outcome, record.steps, kept, record.covered.tolist(), record.cells.tolist()


def acting(**methods):
    """Return a policy whose pilots wander, but with these methods."""
    mind = type("Mind", (Wanderer,), methods)
    return type("Acting", (Wander,), {"pilot": lambda self, briefing: mind(briefing)})()


def test_an_episode_is_the_same_alone_in_a_batch_and_in_a_batched_policy():
    together = [facts(record) for record in fly(Wander(), "w", TEAM, tasks(5))]
    alone = [facts(record) for task in tasks(5) for record in fly(Wander(), "w", TEAM, [task])]
    batched = [facts(record) for record in fly(Batched(), "w", TEAM, tasks(5))]
    assert together == alone == batched


def test_a_record_is_consistent():
    for record in fly(Wander(), "w", TEAM, tasks(6)):
        assert record.covered.shape == (record.steps + 1, 3)
        assert record.cells.shape == (record.steps + 1, 2, 2)
        assert (np.diff(record.covered, axis=0) >= 0).all()
        assert (record.covered[:, 0] >= record.covered[:, 1:].max(axis=1)).all()
        moved = np.abs(np.diff(record.cells.astype(int), axis=0)).sum()
        assert record.metrics["path_length"] == moved
        assert (record.outcome is Outcome.COMPLETE) == (record.curve[-1] == 1.0)
        assert record.steps <= record.budget
        assert record.metrics["pilot_draws"] == 7.0
        t90 = record.metrics["t90"]
        assert t90 is None or (record.curve[int(t90)] >= 0.9 > record.curve[int(t90) - 1])
        assert np.isfinite([value for value in record.metrics.values() if value is not None]).all()


def test_a_policy_that_raises_costs_only_its_own_episodes():
    healthy = {record.task: facts(record) for record in fly(Wander(), "w", TEAM, tasks(12))}
    records = list(fly(Raises(), "w", TEAM, tasks(12)))
    failed = [record for record in records if record.outcome is Outcome.FAILED]
    assert 0 < len(failed) < 12
    for record in records:
        if record in failed:
            assert record.reason.startswith("RuntimeError: motor</script> failure (failing.py:")
            assert record.steps == 5
            assert record.covered.tolist() == healthy[record.task][4][:6]
        else:
            assert facts(record) == healthy[record.task]


def test_a_wrong_action_fails_the_episode_and_says_why():
    (record,) = fly(WrongAction(), "w", TEAM, tasks(1))
    assert record.outcome is Outcome.FAILED
    assert "expected an action from 0 to 4, got 5" in record.reason
    assert record.steps == 0


def test_crashed_uavs_end_the_episode():
    blind = acting(act=lambda self, view: int(self.rng.integers(4)))
    records = list(fly(blind, "w", TEAM, tasks(10)))
    assert {record.outcome for record in records} == {Outcome.ENDED}
    assert all("collision" in record.reason or "out of bounds" in record.reason for record in records)
    assert all(record.metrics["collisions"] == 2 for record in records)


@pytest.mark.parametrize("workers", [0, 2])
def test_engines_fly_the_same_episodes(workers):
    from indoor_explorers.evaluation.harness.engines.local import fly_jobs
    from indoor_explorers.evaluation.harness.experiment.experiment import Job, PolicyChoice
    from indoor_explorers.evaluation.harness.experiment.limits import limits_for

    choice = PolicyChoice.model_validate("random")
    jobs = [Job(choice, TEAM, tuple(tasks(3, start))) for start in (0, 3, 6)]
    flown = [record for records in fly_jobs(jobs, workers, limits_for(2, None, None)) for record in records]
    expected = [facts(record) for record in fly(choice.make(), "random", TEAM, tasks(9))]
    assert sorted((facts(record) for record in flown), key=lambda f: f[0]) == expected


def test_what_was_spent_is_logged_step_by_step():
    linked = TEAM.with_settings({"radio.model": "unlimited", "budget": 400})
    for record in fly(Wander(), "w", linked, tasks(3)):
        for axis in AXES:
            spent = record.spent(axis)
            assert spent.shape == (record.steps + 1,)
            assert (np.diff(spent) >= 0).all()
        assert record.spent("distance")[-1] == record.metrics["path_length"]
        assert record.spent("bytes")[-1] == record.metrics["messages_bytes"] > 0
        assert record.spent("seconds")[-1] == record.metrics["latency_total_s"] > 0
        assert record.metrics["age_of_information"] == 0.0
    (silent,) = fly(Wander(), "w", TEAM.with_settings({"radio.model": "none"}), tasks(1))
    assert silent.metrics["age_of_information"] == pytest.approx(silent.steps / 2)
    assert silent.metrics["auc_worst"] <= silent.metrics["auc_mean"] <= silent.metrics["auc"]


@pytest.mark.parametrize(
    ("told", "reason"),
    [
        ({"draws": "many"}, "expected tally 'draws' to be a finite number, got 'many'"),
        ({"draws": float("nan")}, "expected tally 'draws' to be a finite number, got nan"),
        ({"draws": 10**400}, "OverflowError: int too large to convert to float"),
        (None, "expected tally() to return a dict, got NoneType"),
        ([1.0], "expected tally() to return a dict, got list"),
        ("draws", "expected tally() to return a dict, got str"),
        ({str(each): 1.0 for each in range(10**4)}, "expected at most 64 names in a tally, got 10000"),
        ({"\ud800": 1.0}, r"expected names of a tally to be texts of 1 to 64 characters, got '\\ud800'"),
        ({"n" * 1000: 1.0}, "expected names of a tally to be texts of 1 to 64 characters, got 'nnn"),
        ({float("nan"): 1.0}, "expected names of a tally to be texts of 1 to 64 characters, got nan"),
    ],
)
def test_a_tally_that_breaks_fails_the_episode(told, reason):
    (record,) = fly(acting(tally=lambda self: told), "w", TEAM, tasks(1))
    assert record.outcome is Outcome.FAILED
    assert reason.replace("\\\\", "\\") in record.reason
    assert len(record.reason) < 200
    assert record.covered.shape[0] == record.steps + 1


@pytest.mark.parametrize("value", [99, -7])
def test_an_action_that_lies_about_itself_is_what_it_really_is(value):
    class Liar(int):
        def __le__(self, other):
            return True

        __ge__ = __lt__ = __gt__ = __le__

        def __index__(self):
            return 2

    (record,) = fly(acting(act=lambda self, view: Liar(value)), "w", TEAM, tasks(1))
    assert record.outcome is Outcome.FAILED
    assert record.steps == 0
    assert f"expected an action from 0 to 4, got {value}" in record.reason


def test_a_reason_is_short_and_has_no_control_characters():
    class Shouts(Wander):
        def pilot(self, briefing):
            raise RuntimeError("\x1b[31m\x07\u202e" + "x" * 10**5)

    (record,) = fly(Shouts(), "w", TEAM, tasks(1))
    assert r"RuntimeError: \x1b[31m\x07\u202exxx" in record.reason
    assert record.reason.isprintable()
    assert len(record.reason) < 600


def test_compiling_is_no_part_of_a_decision(monkeypatch):
    clock = [0.0]
    monkeypatch.setattr("time.perf_counter", lambda: clock[0])
    monkeypatch.setattr(event, "timer", lambda: clock[0])

    def act(self, view):
        clock[0] += 0.25
        if view.step == 2:
            with event.trigger_event("numba:compiler_lock"), event.trigger_event("numba:compiler_lock"):
                clock[0] += 100.0
        return Wanderer.act(self, view)

    alone = acting(act=act)
    for policy in (alone, type("Together", (type(alone),), {"batched": True})()):
        (record,) = fly(policy, "w", TEAM.with_settings({"budget": 4}), tasks(1))
        np.testing.assert_allclose(np.diff(record.seconds), 2 * 0.25)
        assert record.metrics["latency_p99_us"] == record.metrics["latency_p50_us"] == 0.25e6


def test_what_numba_really_compiles_is_no_part_of_a_decision():
    def act(self, view):
        if view.step == 1:
            numba.njit(lambda x: x + view.step)(1)
        return Wanderer.act(self, view)

    with event.install_recorder("numba:compiler_lock") as recorder:
        (record,) = fly(acting(act=act), "w", TEAM.with_settings({"budget": 3}), tasks(1))
    assert len(recorder.buffer) >= 2 * TEAM.team
    assert np.diff(record.seconds)[1] < recorder.buffer[-1][0] - recorder.buffer[0][0]


def test_only_a_policy_that_batches_is_asked_for_many_uavs_at_once():
    sizes = []

    class Counts(Wander):
        def act(self, pilots, views):
            sizes.append(len(pilots))
            return super().act(pilots, views)

    alone = [facts(record) for record in fly(Counts(), "w", TEAM, tasks(3))]
    assert set(sizes) == {1}
    sizes.clear()
    together = [facts(record) for record in fly(type("Many", (Counts,), {"batched": True})(), "w", TEAM, tasks(3))]
    assert max(sizes) == 3 * TEAM.team
    assert alone == together
