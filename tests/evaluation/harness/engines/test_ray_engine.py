"""The Ray engine, on a cluster of a head without CPUs and two nodes of one CPU, all on this machine."""

import os
import socket
import sys
import threading

import numpy as np
import pytest
import ray

from indoor_explorers.env import InputError
from indoor_explorers.env.scenarios.presets import on_files
from indoor_explorers.evaluation import compare
from indoor_explorers.evaluation.cli.parser import main
from indoor_explorers.evaluation.harness.engines import ray_engine as engine
from indoor_explorers.evaluation.harness.engines.factory import make_engine
from indoor_explorers.evaluation.harness.episodes.record import Outcome
from indoor_explorers.evaluation.harness.experiment.experiment import Job, PolicyChoice, Task
from indoor_explorers.evaluation.harness.results.results import Results
from tests.evaluation.cli.test_cli import PLUGINS, rows

# Ray leaves sockets, files and processes of its own to the garbage collector.
pytestmark = [
    pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning"),
    pytest.mark.xdist_group("ray"),
]

PLAN = {"scenario": "thesis-open", "policies": [f"{PLUGINS}:Wander", "frontier-nearest"], "episodes": 30}


class Watcher:
    """Does something once, when the first records are stored."""

    def __init__(self, deed):
        self.deed = deed

    def begin(self, total, missing):
        pass

    def flown(self, records, seconds_left):
        deed, self.deed = self.deed, lambda: None
        deed()


def interrupt():
    raise KeyboardInterrupt


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    """The rows of the local engine."""
    out = tmp_path_factory.mktemp("local")
    compare(out, **PLAN, workers=0)
    return rows(out)


ON_RAY = {"engine": "ray"}


@pytest.mark.slow
def test_the_same_summary_as_the_local_engine(cluster, expected, tmp_path):
    compare(tmp_path, **PLAN, **ON_RAY, address=cluster.address)
    assert rows(tmp_path) == expected
    assert not ray.is_initialized()


@pytest.mark.slow
def test_a_node_that_dies_half_way_changes_nothing(connected, expected, tmp_path):
    nodes = list(connected.worker_nodes)
    compare(tmp_path, **PLAN, **ON_RAY, watcher=Watcher(lambda: connected.remove_node(nodes[0], False)))
    connected.add_node(num_cpus=1, object_store_memory=100 * 2**20)
    assert rows(tmp_path) == expected


@pytest.mark.slow
@pytest.mark.usefixtures("connected")
def test_an_interrupted_run_goes_on_with_the_other_engine(expected, tmp_path):
    for first, second in ((ON_RAY, {"workers": 0}), ({"workers": 0}, ON_RAY)):
        out = tmp_path / first.get("engine", "local")
        with pytest.raises(KeyboardInterrupt):
            compare(out, **PLAN, **first, watcher=Watcher(interrupt))
        assert 0 < len(Results.load(out).records) < 2 * PLAN["episodes"]
        compare(out, **PLAN, **second)
        assert rows(out) == expected


@pytest.mark.slow
@pytest.mark.usefixtures("connected")
def test_nodes_need_no_map_files(tmp_path):
    room = np.zeros((12, 9), np.uint8)
    room[4, 2:7] = 1
    np.save(tmp_path / "one.npy", room)
    np.save(tmp_path / "two.npy", room.T)
    scenario = on_files([str(tmp_path / "one.npy"), str(tmp_path / "two.npy")], None).for_evaluation()
    tasks = tuple(Task(scenario.name, index, seed) for index in (0, 1) for seed in range(2))
    plans = [scenario.map.floorplan(index, 0) for index in (0, 1)]
    jobs = [Job(PolicyChoice.model_validate("random"), scenario, tasks)]
    compare(tmp_path / "local", scenario=scenario, policies=["random"], episodes=2, workers=0)
    lost = scenario.model_copy(update={"map": scenario.map.model_copy(update={"paths": ("gone/a.npy", "gone/b.npy")})})
    away = (job._replace(scenario=lost) for job in jobs)
    (records,) = (engine.fly_on_node(engine.Origin.here(), (60.0, None), job, *plans) for job in away)
    engine.supervisor(60.0, None).close()
    engine.supervisor.cache_clear()
    assert {record.floorplan.digest for record in records} == {plan.digest for plan in plans}
    compare(tmp_path / "ray", scenario=scenario, policies=["random"], episodes=2, **ON_RAY)
    assert rows(tmp_path / "ray") == rows(tmp_path / "local")


@pytest.mark.slow
@pytest.mark.usefixtures("connected")
def test_a_plug_in_that_raises_costs_only_its_own_episodes(tmp_path):
    plan = {"scenario": "thesis-open", "policies": [f"{PLUGINS}:Raises", f"{PLUGINS}:Wander"], "episodes": 12}
    compare(tmp_path / "ray", **plan, **ON_RAY, workers=1)
    compare(tmp_path / "local", **plan, workers=0)
    assert rows(tmp_path / "ray") == rows(tmp_path / "local")
    failed = [record for record in Results.load(tmp_path / "ray").records if record.outcome is Outcome.FAILED]
    assert {record.policy for record in failed} == {f"{PLUGINS}:Raises"}
    assert 0 < len(failed) < 12


@pytest.mark.slow
@pytest.mark.usefixtures("connected")
def test_a_plug_in_that_ends_its_process_costs_only_its_own_episodes(tmp_path):
    plan = {"scenario": "thesis-open", "policies": [f"{PLUGINS}:Exits", "random"], "episodes": 4}
    compare(tmp_path, **plan, **ON_RAY)
    records = Results.load(tmp_path).records
    failed = [record for record in records if record.outcome is Outcome.FAILED]
    assert len(records) == 8
    assert {(record.policy, record.task.seed % 2, record.steps) for record in failed} == {(f"{PLUGINS}:Exits", 1, 5)}
    assert {record.reason for record in failed} == {"the process of the policy ended with exit code 3"}


@pytest.mark.slow
@pytest.mark.usefixtures("connected")
def test_nodes_with_other_versions_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(engine, "_versions", lambda: (("numpy", "1.0"),))
    with pytest.raises(InputError, match=r"node .* has numpy 2.*, not 1\.0; install"):
        compare(tmp_path, **PLAN, **ON_RAY)


def test_a_worker_finds_what_the_driver_finds(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.chdir(os.getcwd())  # noqa: PTH109  # restores the folder
    there = engine.Origin.here()._replace(folder=str(tmp_path), paths=("somewhere",))
    engine.prepare(there)
    assert os.getcwd() == str(tmp_path)  # noqa: PTH109  # what prepare has set
    assert sys.path[-1] == "somewhere"


@pytest.fixture
def other_server():
    """A server that speaks, but not HTTP/2."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def answer():
            line, _ = server.accept()
            with line:
                line.recv(100)
                line.sendall(b"SSH-2.0-OpenSSH_9.9\r\n")

        thread = threading.Thread(target=answer)
        thread.start()
        yield f"127.0.0.1:{server.getsockname()[1]}"
        thread.join()


@pytest.mark.parametrize("address", ["127.0.0.1:1", "127.0.0.1:99999", "nonsense", "ray://127.0.0.1:1", None])
def test_a_bad_address_is_one_line(address, other_server, tmp_path, capsys):
    if address is None:
        address = other_server
    else:
        socket.create_connection(("127.0.0.1", int(other_server.rpartition(":")[2]))).close()
    words = ["compare", "--policies", "random", "--engine", "ray", "--address", address]
    assert main([*words, "--out", str(tmp_path / "out")]) == 2
    errors = capsys.readouterr().err
    assert errors.count("\n") == 1
    assert f"got no cluster at {address}" in errors
    assert not (tmp_path / "out").exists()


def test_engines_refuse_what_they_cannot_use(monkeypatch):
    with pytest.raises(InputError, match="local or ray, got 'spark'"):
        make_engine("spark")
    with pytest.raises(InputError, match="expected --engine ray with --address"):
        make_engine("local", address="127.0.0.1:6379")
    with pytest.raises(InputError, match="at least 1 of --workers"):
        make_engine("ray", workers=0)
    monkeypatch.setitem(sys.modules, "ray", None)
    monkeypatch.delitem(sys.modules, "indoor_explorers.evaluation.harness.engines.ray_engine")
    with pytest.raises(InputError, match=r"install indoor-explorers\[ray\]"):
        make_engine("ray")
