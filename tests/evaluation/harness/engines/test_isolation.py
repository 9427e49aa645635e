"""An isolated policy flies as it does elsewhere, in a process that never has the world."""

import os
import pickle
import signal
import sys
from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from indoor_explorers.env import InputError, Policy, View, World
from indoor_explorers.env.grid.cells import Action
from indoor_explorers.env.policies.view import LIVE_ARRAYS, PLAIN_FIELDS, arrays_of, values_of, view_of
from indoor_explorers.evaluation.driver import _flies_isolated, _of_all_runs
from indoor_explorers.evaluation.harness.engines.policy_handle import PolicyHandle, ProcessEnded
from indoor_explorers.evaluation.harness.engines.policy_process import PolicyServer
from indoor_explorers.evaluation.harness.engines.process_handle import UNREADABLE, ProcessExit
from indoor_explorers.evaluation.harness.engines.remote_pilots import RemotePilots
from indoor_explorers.evaluation.harness.engines.supervisor import Supervisor, WorkerHandle
from indoor_explorers.evaluation.harness.engines.worker import _here
from indoor_explorers.evaluation.harness.episodes.pilots import BatchFailed, LocalPilots
from indoor_explorers.evaluation.harness.episodes.record import Outcome
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.episodes.shared_memory import Clock, SharedStepBuffer, SharedViews
from indoor_explorers.evaluation.harness.experiment.experiment import PolicyChoice
from indoor_explorers.evaluation.harness.experiment.limits import Limits
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from tests.evaluation.harness.engines.limits import PATIENT
from tests.evaluation.harness.engines.test_supervisor import TEAM, facts, job, own
from tests.evaluation.plugins import NotesItsEnd, Raises, Searches, Wander
from tests.marks import slow
from tests.processes import runs, wait_until

#: Settings of a task in which every field of a view tells something.
EVERY_FIELD = {
    "noise.misses": 0.1,
    "drift.rate": 0.1,
    "lidar.field_of_view": 120.0,
    "base.at": "start",
    "base.radius": 1.0,
    "radio.loss": 0.5,
}
#: No other number of a process is this one by chance.
SEED = 987_654_321_012_345


@pytest.fixture(scope="module")
def supervisor(plugins_found):
    supervisor = Supervisor(PATIENT)
    yield supervisor
    supervisor.close()


@pytest.mark.parametrize(
    "name",
    [
        "random",
        "reference",
        "dddqn",
        *slow("frontier", "frontier-nearest", "pso"),
    ],
)
def test_isolated_policies_fly_the_same_episodes(name, supervisor):
    choice, plain = PolicyChoice(use=name, name=name), own(name)
    flown = supervisor.fly(plain._replace(isolated=True, privileged=choice.make().privileged))
    here = fly(choice.make(), name, TEAM, plain.tasks)
    assert sorted(map(facts, flown), key=str) == sorted(map(facts, here), key=str)
    assert all(record.metrics["latency_p50_us"] > 0.0 for record in flown)


def test_a_failure_is_told_in_the_same_words(supervisor):
    plain = job("Raises", range(8))
    flown, here = supervisor.fly(plain), fly(Raises(), "Raises", TEAM, plain.tasks)
    assert sorted(map(facts, flown), key=str) == sorted(map(facts, here), key=str)
    assert any("failure (failing.py:" in record.reason for record in flown)


def test_the_process_of_a_policy_holds_no_world_no_map_and_no_seed(supervisor):
    searching = job("Searches", [SEED], seed=SEED)
    (record,) = supervisor.fly(searching)
    assert record.reason == ""
    (found,) = fly(Searches(SEED), "Searches", TEAM, searching.tasks)
    assert "found ['Floorplan', 'Task', 'World', 'the seed']" in found.reason


def test_the_map_is_told_only_to_a_policy_whose_facts_say_so(supervisor):
    claims = job("ClaimsPrivilege", [0])
    (record,) = supervisor.fly(claims)
    assert record.reason == ""
    (record,) = supervisor.fly(claims._replace(privileged=True))
    assert "AssertionError" in record.reason


def test_what_a_uav_knows_cannot_be_written_to_there(supervisor):
    vandal = job("VandalInAllWays", [2])
    assert [facts(record) for record in supervisor.fly(vandal)] == [
        facts(record) for record in fly(Wander(), "Wander", TEAM, vandal.tasks)
    ]


def test_a_policy_that_cannot_be_made_fails_or_is_refused(supervisor):
    (record,) = supervisor.fly(job("NeverMade", [0]))
    assert (record.outcome, record.steps) == (Outcome.FAILED, 0)
    assert "RuntimeError: no weights (failing.py:" in record.reason
    with pytest.raises(InputError, match="unknown parameter 'pace'"):
        supervisor.fly(job("Wander", [0], pace=3))


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="other systems cannot end a process whatever it does")
def test_the_process_of_a_policy_ends_with_its_worker_whatever_it_does(tmp_path, plugins_found):
    told = tmp_path / "pid"
    worker = WorkerHandle(Limits(None, PATIENT.memory))
    try:
        assert worker.receive() is None
        worker.send(job("HangsInCAndTellsWhere", [0], where=str(told)))
        wait_until(lambda: told.exists() and told.read_text())
        pid = int(told.read_text())
        assert runs(pid)
    finally:
        worker.close()
    wait_until(lambda: not runs(pid))


@pytest.mark.slow
def test_a_worker_survives_the_process_of_its_policy(supervisor):
    supervisor.fly(own("random"))
    (worker,) = supervisor._workers
    (failed, _) = supervisor.fly(job("Exits", [1, 0]))
    assert failed.reason == "the process of the policy ended with exit code 3" or failed.task.seed == 0
    assert supervisor._workers == [worker]


@pytest.mark.slow
def test_the_process_of_a_policy_waits_while_its_worker_flies_others(supervisor):
    supervisor.fly(job("Wander", [0]))
    supervisor.fly(own("random"))
    assert supervisor.serves == job("Wander").policy
    supervisor.fly(own("random")._replace(isolated=True))
    assert supervisor.serves is None


def test_who_flies_isolated():
    inside, outside = PolicyChoice(use="random", name="a"), PolicyChoice(use="tests.x:Y", name="b")
    options = {"plug-ins": [False, True], "all": [True, True], "none": [False, False]}
    for isolate, expected in options.items():
        for workers, isolated in ((None, expected), (2, expected), (0, [False, False])):
            how = ComparisonRequest.of(isolate=isolate, workers=workers)
            assert [_flies_isolated(choice, how) for choice in (inside, outside)] == isolated
    assert ComparisonRequest().isolate == "plug-ins"
    with pytest.raises(InputError, match="plug-ins"):
        ComparisonRequest.of(isolate="some")


def test_a_policy_flew_isolated_if_it_did_in_all_runs():
    stored = {str(now): {"hash": "1", "isolated": now} for now in (True, False)} | {"None": {"hash": "1"}}
    for now in (True, False):
        told = _of_all_runs({name: {"hash": "1", "isolated": now} for name in (*stored, "new")}, stored)
        assert {name: facts["isolated"] for name, facts in told.items()} == (
            {"True": True, "False": False, "None": None, "new": True} if now else dict.fromkeys(told, False)
        )
    changed = _of_all_runs({"False": {"class": "another", "isolated": True}}, stored)
    assert changed["False"]["isolated"]


class Answers:
    """A process that answers what it is told to."""

    def __init__(self, *answers):
        self.views, self.answers, self.seconds = SharedViews(), list(answers), 1.0

    def load(self, choice):
        return self.ask()

    def ask(self, *question):
        return self.answers.pop(0)

    def unreadable(self):
        return ProcessEnded(ProcessExit(UNREADABLE))


UNTOLD = [0.1, 1, None, ""]
DECISIONS = [
    None, 7, [], [UNTOLD, UNTOLD, UNTOLD], [UNTOLD, 3], [UNTOLD, [0.1, 5, None, ""]], [UNTOLD, [0.1, True, None, ""]],
    [UNTOLD, [0.1, "up", None, ""]], [UNTOLD, [-1.0, 1, None, ""]], [UNTOLD, [float("nan"), 1, None, ""]],
    [UNTOLD, ["1", 1, None, ""]], [UNTOLD, [1e308, 4, None, ""]], [[.6, 1, None, ""], [.6, 1, None, ""]],
    [UNTOLD, [0.1, 1, [1.0] * 17, ""]], [UNTOLD, [0.1, 1, ["x"], ""]],
    [UNTOLD, [0.1, 1, {"a": 1}, ""]], [UNTOLD, [0.1, 1, None, 3]], [UNTOLD, [0.1, 1, None]],
]  # fmt: skip


def pilots_told(*answers):
    """Pilots whose process gives these answers after they were briefed, and the views of their UAVs."""
    world = World(TEAM)
    world.reset([0])
    pilots = RemotePilots(Answers({}, [], *answers), job("Wander"))
    assert pilots.brief({0: [world.briefing(0, agent) for agent in (0, 1)]}) == {}
    return pilots, {(0, agent): world.view(0, agent) for agent in (0, 1)}


@pytest.mark.parametrize("answer", DECISIONS)
def test_decisions_that_are_none_end_the_process(answer):
    pilots, views = pilots_told(answer)
    with pytest.raises(ProcessEnded, match="cannot be read"):
        pilots.decide(views)


def test_decisions_are_plain_numbers_and_failures_a_line():
    pilots, views = pilots_told([[0.5, 3, [1.0, 2.0], ""], [0.0, 4, None, "broke\x1b\ndown"]])
    first, second = pilots.decide(views).values()
    assert first == (0.5, 3, (1.0, 2.0), "", False)
    assert second.failure == r"broke\x1b down"


def test_a_failure_of_several_episodes_together_is_nobodys_yet():
    pilots, views = pilots_told(None)
    pilots._process.views.begin([*views, (1, 0)], (16, 16), writing=True)
    with pytest.raises(BatchFailed):
        pilots.decide(views | {(1, 0): views[0, 0]})


@pytest.mark.parametrize("answer", [None, [[1, {}]], [[0, 3]], [[0]], [["0", {}]]])
def test_statistics_that_are_none_end_the_process(answer):
    pilots, _ = pilots_told(answer)
    with pytest.raises(ProcessEnded, match="cannot be read"):
        pilots.tally([0])


def test_statistics_are_checked_again():
    pilots, _ = pilots_told([[0, {"pilot_a": float("inf")}]])
    assert pilots.tally([0]) == {0: "expected tally 'a' to be a finite number, got inf"}


def test_a_process_that_answers_no_json_is_killed(plugins_found):
    process = PolicyHandle.started(PATIENT)
    try:
        process.load(PolicyChoice(use="tests.evaluation.plugins:Wander", name="w"))
        os.kill(process._process.pid, signal.SIGSTOP)
        process.kill()
        with pytest.raises(ProcessEnded, match="SIGKILL"):
            process.ask("unload")
    finally:
        process.close()


def test_views_are_live_read_only_and_outlast_their_batch():
    world = World(TEAM)
    world.reset([0])
    writer = SharedViews()
    reader = SharedViews(SimpleNamespace(detach=lambda: os.dup(writer._file)))
    for uavs in ([(0, 0), (0, 1)], [(0, 0)]):
        writer.begin(uavs, (16, 16), writing=True)
        reader.begin(uavs, (16, 16))
    view = world.view(0, 0)
    shown = view_of(reader.arrays[0, 0], values_of(view))
    assert shown.log_odds is None
    assert not shown.belief.any()
    writer.write((0, 0), view)
    assert_same(shown, view)
    writer.begin([(place, 0) for place in range(100)], (64, 64), writing=True)
    assert shown.belief.any()


def assert_same(shown, view):
    """A view is another one in all its fields, and its arrays can be read only."""
    for name, mine, other in zip(View._fields, shown, view, strict=True):
        assert type(mine) is type(other), name
        if name in PLAIN_FIELDS:
            assert mine == other, name
        elif mine is not None:
            np.testing.assert_array_equal(mine, other, name)
            assert mine.dtype == other.dtype, name
            assert mine.flags.c_contiguous, name
            assert mine.flags.aligned, name
            assert not mine.flags.writeable, name


@dataclass(frozen=True)
class Looks(Policy):
    """Keeps the views that it is shown."""

    views: list[View] = field(default_factory=list)

    def pilot(self, briefing):
        return SimpleNamespace(message=None, done=False, tally=dict)

    def act(self, pilots, views):
        self.views.extend(views)
        return [int(Action.STAY) for _ in views]


class SamePlace:
    """A process that answers here, where all that is sent is pickled."""

    def __init__(self, policy):
        self.views, self.seconds = SharedViews(), 60.0
        reader = SharedViews(SimpleNamespace(detach=lambda: os.dup(self.views._file)))
        self.server = PolicyServer(reader)
        self.policy = policy

    def load(self, choice):
        return self.server.load(SimpleNamespace(make=lambda: self.policy))

    def ask(self, question, *arguments):
        return getattr(self.server, question)(*pickle.loads(pickle.dumps(arguments)))


@pytest.mark.parametrize("settings", [{}, EVERY_FIELD], ids=["exact", "uncertain"])
def test_every_field_of_a_view_travels_unchanged(settings):
    task = TEAM.with_settings(settings)
    world, policy = World(task), Looks()
    world.reset([3])
    pilots = RemotePilots(SamePlace(policy), job("Wander"))
    assert pilots.brief({0: [world.briefing(0, agent) for agent in range(task.team)]}) == {}
    for step in range(20):
        for agent in range(task.team):
            world.post(0, agent, (float(step), 0.5))
        views = {(0, agent): world.view(0, agent) for agent in range(task.team)}
        assert len(pilots.decide(views)) == task.team
        for shown, view in zip(policy.views[-task.team :], views.values(), strict=True):
            assert_same(shown, view)
        world.step(np.full((1, task.team), step % task.actions))
    if settings:
        told = dict(zip(View._fields, zip(*policy.views, strict=True), strict=True))
        assert all(any(map(bool, told[name])) for name in PLAIN_FIELDS)
        assert all(any(array.any() for array in told[name]) for name in LIVE_ARRAYS)


def test_a_field_is_an_array_of_the_worlds_or_a_plain_value():
    assert {*LIVE_ARRAYS, *PLAIN_FIELDS} == set(View._fields)
    task = TEAM.with_settings(EVERY_FIELD)
    world = World(task)
    world.reset([3])
    view = world.view(0, 0)
    assert view_of(arrays_of(view), values_of(view)) == view
    for name, array in LIVE_ARRAYS.items():
        shown = getattr(view, name)
        assert (shown.dtype, shown.shape) == (array.dtype, array.shape_on((16, 16)))
    assert not any(isinstance(value, np.ndarray) for value in values_of(view))


def test_policies_are_deleted_while_the_clock_runs():
    buffer, server, flown = SharedStepBuffer(), PolicyServer(views := SharedViews()), job("NotesItsEnd", [0])
    NotesItsEnd.CLOCK = buffer.clock
    assert len(list(_here(flown, buffer))) == 1
    assert NotesItsEnd.TIMED == [True]
    NotesItsEnd.CLOCK = views.clock
    assert server.load(flown.policy) == {}
    server.unload()
    assert NotesItsEnd.TIMED == [True, True]


def test_pilots_of_failed_episodes_are_deleted_with_the_others():
    world = World(TEAM)
    world.reset([0])
    pilots = LocalPilots(Wander(), Clock())
    pilots.brief({0: [world.briefing(0, agent) for agent in (0, 1)]})
    assert pilots.tally([]) == {}
    assert pilots._pilots == {}
