"""A policy that breaks, in whatever way, costs its own episodes and nothing else."""

import threading
import time

import numpy as np
import pytest

from indoor_explorers.env import PRESETS
from indoor_explorers.env.errors import RunError
from indoor_explorers.evaluation.harness.engines.supervisor import Supervisor, WorkerHandle
from indoor_explorers.evaluation.harness.episodes.metrics import OF_THE_MACHINE
from indoor_explorers.evaluation.harness.episodes.record import Outcome, Record
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.episodes.shared_memory import overdue_reason
from indoor_explorers.evaluation.harness.experiment.experiment import Job, PolicyChoice, Task
from indoor_explorers.evaluation.harness.experiment.limits import Limits
from tests.evaluation.harness.engines.limits import LIMITS, SECONDS
from tests.evaluation.plugins import WAYS, Vandal, Wander

TEAM = PRESETS["thesis-team-2"].for_evaluation().with_settings({"radio.model": "unlimited", "budget": 60})
#: A leak reaches this memory in seconds.
SMALL = 600_000_000
GUILTY = 1


def job(policy, seeds=(1, 0, 2), **parameters):
    choice = PolicyChoice(use=f"tests.evaluation.plugins:{policy}", name=policy, parameters=parameters)
    return Job(choice, TEAM, tuple(Task(TEAM.name, 0, seed) for seed in seeds), isolated=True)


def facts(record):
    kept = {name: value for name, value in record.metrics.items() if name not in OF_THE_MACHINE}
    arrays = record.covered, record.cells, record.actions, record.sent
    return record.task, record.outcome, record.reason, kept, [array.tolist() for array in arrays]


@pytest.fixture(scope="module")
def supervisor(plugins_found):
    supervisor = Supervisor(LIMITS._replace(memory=SMALL))
    yield supervisor
    supervisor.close()


@pytest.fixture(scope="module")
def patient(plugins_found):
    """A supervisor without a time limit: taking memory takes time."""
    supervisor = Supervisor(Limits(None, SMALL))
    yield supervisor
    supervisor.close()


@pytest.fixture(scope="module")
def honest():
    """What an honest policy does on the same tasks, by seed."""
    return {record.task.seed: record for record in fly(Wander(), "w", TEAM, job("Wander", range(4)).tasks)}


def check(records, honest, reason, steps):
    """Only the guilty episode failed, and everything in the records is as an honest policy's up to there."""
    assert [record.task.seed for record in sorted(records, key=lambda r: r.task)] in ([0, 1, 2], [GUILTY])
    for record in records:
        undisturbed = honest[record.task.seed]
        if record.task.seed != GUILTY:
            assert facts(record) == facts(undisturbed)
            continue
        assert record.outcome is Outcome.FAILED
        assert reason in record.reason
        assert record.steps == steps
        for name in ("covered", "cells", "sent", "actions"):
            np.testing.assert_array_equal(
                getattr(record, name), getattr(undisturbed, name)[: steps + (name != "actions")]
            )
        assert record.metrics["path_length"] == record.distance[-1]
        assert record.metrics["messages_bytes"] == undisturbed.sent[steps]


SLOW = pytest.mark.slow  # each costs a process, in a way much like another one's
OVERDUE = overdue_reason(SECONDS)


@pytest.mark.parametrize(
    ("policy", "reason"),
    [
        ("ReturnsNothing", "InputError: expected an int from 0 to 4, got the str 'up'"),
        pytest.param("ExitsPython", "SystemExit: enough", marks=SLOW),
        pytest.param("HangsInSleep", OVERDUE, marks=SLOW),
        pytest.param("HangsInPython", OVERDUE, marks=SLOW),
        pytest.param("HangsTogether", OVERDUE, marks=SLOW),
        pytest.param("HangsForGood", OVERDUE, marks=SLOW),
        pytest.param("HangsInC", OVERDUE, marks=SLOW),
        pytest.param("Exits", "the process of the policy ended with exit code 3", marks=SLOW),
        pytest.param("KillsItself", "the process of the policy was killed by signal 9 (SIGKILL)", marks=SLOW),
        pytest.param("Segfaults", "the process of the policy was killed by signal 11 (SIGSEGV)", marks=SLOW),
    ],
)
def test_a_policy_that_breaks_costs_only_its_own_episode(policy, reason, supervisor, honest):
    check(supervisor.fly(job(policy)), honest, reason, steps=5)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("way", "reason"),
    [
        ("answers slowly", OVERDUE),
        pytest.param("begins to answer", OVERDUE, marks=SLOW),
        pytest.param("says that it compiles", OVERDUE, marks=SLOW),
        pytest.param("stops its worker", "the process of the policy was stopped for 3 s", marks=SLOW),
    ],
)
def test_a_policy_that_hides_that_it_hangs_fails_alone(way, reason, supervisor, honest):
    check(supervisor.fly(job("Deceives", [1], way=way)), honest, reason, steps=5)


@pytest.mark.parametrize("policy", [pytest.param("Forks", marks=SLOW)])
def test_copies_of_its_process_that_a_policy_makes_end_with_the_decision(policy, supervisor, honest):
    assert [facts(record) for record in supervisor.fly(job(policy, [2]))] == [facts(honest[2])]


@pytest.mark.slow
@pytest.mark.parametrize("seeds", [[GUILTY], [1, 0, 2]], ids=["alone", "among others"])
def test_a_leak_is_stopped(seeds, patient, honest):
    records = patient.fly(job("LeaksAtOnce", seeds))
    (failed,) = [record for record in records if record.outcome is Outcome.FAILED]
    assert failed.steps > 5
    check(records, honest, "worker used more than 0.6 GB of memory (--memory-limit)", failed.steps)


@SLOW
def test_a_slow_leak_of_a_whole_job_is_nobodys_fault(patient, honest):
    records = patient.fly(job("LeaksSlowly", [0, 2, 100, 101, 102]))
    assert {record.outcome for record in records} <= {Outcome.BUDGET, Outcome.COMPLETE}
    assert facts(records[0]) == facts(honest[0])


@pytest.mark.slow
def test_a_pilot_that_never_comes_about(supervisor, honest):
    check(supervisor.fly(job("HangsAtTheStart")), honest, OVERDUE, steps=0)


@pytest.mark.slow
def test_a_policy_that_dies_always_fails_always(supervisor):
    records = supervisor.fly(job("Dies", [1, 0]))
    assert [(record.outcome, record.steps) for record in records] == [(Outcome.FAILED, 0)] * 2


@pytest.mark.parametrize("way", WAYS)
def test_what_a_uav_knows_cannot_be_written_to(way, honest):
    records = list(fly(Vandal(way), "Vandal", TEAM, job("Vandal").tasks))
    check(records, honest, "Error: ", steps=5)
    assert not any("that worked" in record.reason for record in records)


def own(policy):
    return Job(PolicyChoice(use=policy, name=policy), TEAM, job("").tasks)


def test_a_policy_from_outside_has_a_process_of_its_own_and_changes_no_other_ones_flights(supervisor, honest):
    before = supervisor.fly(own("random"))
    supervisor.fly(job("Meddles"))
    after, others = supervisor.fly(own("random")), supervisor.fly(job("Wander"))
    assert [facts(record) for record in after] == [facts(record) for record in before]
    assert [facts(record) for record in others] == [facts(honest[seed]) for seed in (1, 0, 2)]


@pytest.mark.parametrize("policy", ["Boasts", pytest.param("Teleports", marks=SLOW)])
def test_what_counts_is_worked_out_where_the_policy_was_not_loaded(policy, supervisor, honest):
    assert [facts(record) for record in supervisor.fly(job(policy))] == [facts(honest[seed]) for seed in (1, 0, 2)]


def test_the_packages_own_policies_share_a_process(supervisor):
    supervisor.fly(own("random"))
    (process,) = supervisor._workers
    supervisor.fly(own("frontier-nearest"))
    assert supervisor._workers == [process]


@SLOW
def test_pilots_that_hang_when_they_are_deleted_are_stopped(supervisor):
    (record,) = supervisor.fly(job("HangsWhenDeleted", [0]))
    assert (record.outcome, record.reason) == (Outcome.FAILED, OVERDUE)


def test_prints_do_not_disturb(supervisor, honest, capfd):
    records = supervisor.fly(job("Prints"))
    assert [facts(record) for record in records] == [facts(honest[seed]) for seed in (1, 0, 2)]
    assert capfd.readouterr().out == ""


def test_an_honest_policy_after_all_that(supervisor, honest):
    assert [facts(record) for record in supervisor.fly(job("Batched"))] == [facts(honest[s]) for s in (1, 0, 2)]


def test_closing_ends_a_flight_at_once():
    supervisor = Supervisor(Limits(None, LIMITS.memory))
    raised = []

    def fly_on():
        try:
            supervisor.fly(job("HangsInC"))
        except RunError as error:
            raised.append(str(error))

    thread = threading.Thread(target=fly_on)
    thread.start()
    time.sleep(1.0)
    supervisor.close()
    thread.join(10.0)
    assert not thread.is_alive()
    assert raised == ["the supervisor of these workers was closed"]


@pytest.mark.slow
def test_a_task_of_which_the_driver_has_an_episode_brings_no_map_and_the_known_bound(supervisor):
    plain = job("Exits")
    new, told = supervisor.fly(plain), supervisor.fly(plain._replace(bounds={task: 7 for task in plain.tasks[:2]}))
    assert [isinstance(record, Record) for record in sorted(new, key=lambda r: r.task)] == [True] * 3
    for record, other in zip(*(sorted(records, key=lambda r: r.task) for records in (new, told)), strict=True):
        known = other.task in plain.tasks[:2]
        assert isinstance(other, Record) is (not known or other.outcome is Outcome.FAILED)
        assert other.bound == (7 if known else record.bound) > 0
        assert record.flew_like(other)


@pytest.mark.slow
@pytest.mark.usefixtures("plugins_found")
def test_the_steps_of_a_flight_are_forgotten_with_the_next_job():
    worker = WorkerHandle(Limits(None, LIMITS.memory))
    try:
        assert worker.receive() is None
        worker.send(job("Wander", [2]))
        (record,) = iter(worker.receive, None)
        assert len(worker.steps(2).actions) == record.steps
        worker.send(job("Wander", [2, 3]))
        assert len(list(iter(worker.receive, None))) == 2
        assert len(worker.steps(2).actions) == 0
    finally:
        worker.close()
