"""A peer answers from a process of its own; one that hangs, dies or sends no answer is ended with a line about it."""

import os
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from indoor_explorers.env.errors import InputError
from indoor_explorers.planners.toolbox.peers.process import Need, Peer, PeerFailure, PeerProcess
from tests.processes import runs, wait_until

#: Written in the folder of the clone, as the code of a peer.
THEIRS = """
import numpy
print("loading")
def doubled(cells):
    print("doubling")
    return 2 * cells
"""
#: A script that drives it.
SCRIPT = """
import os, signal, subprocess, sys, time
from simulator import doubled

def double(cells):
    return {"cells": doubled(cells), "pid": os.getpid(), "folder": os.getcwd(), "path": sys.path[0]}

def ours():
    return {"loaded": [name for name in sys.modules if name.startswith("indoor_explorers")]}

def hang():
    time.sleep(60)

def start_another():
    child = subprocess.Popen(["sleep", "60"])
    print("started", file=sys.stderr, flush=True)
    return {"pid": child.pid}

def die(code):
    print("Killed by the peer\\nlast words", file=sys.stderr, flush=True)
    os._exit(code)

def kill():
    os.kill(os.getpid(), signal.SIGKILL)

def close():
    for descriptor in range(3, 20):
        try:
            os.close(descriptor)
        except OSError:
            pass
    time.sleep(60)

def garble():
    for descriptor in range(3, 20):
        try:
            os.write(descriptor, b"Segmentation fault in ortools")
        except OSError:
            pass
    time.sleep(60)

def fail():
    raise ValueError("no path\\nto node 3")

def lack():
    import skimage_that_is_not_there.measure

def wrong():
    return [1]

def unsendable():
    return {"value": object()}
"""


@pytest.fixture
def peer(tmp_path: Path) -> Peer:
    """Return a peer whose clone and script are in a folder, run by this interpreter."""
    (tmp_path / "clone").mkdir()
    (tmp_path / "clone" / "simulator.py").write_text(THEIRS)
    (tmp_path / "script.py").write_text(SCRIPT)
    needs = (Need(package="numpy"),)
    return Peer(
        interpreter=sys.executable, folder=tmp_path / "clone", script=tmp_path / "script.py", needs=needs, time_limit=20
    )


@pytest.fixture
def process(peer: Peer):
    with PeerProcess(peer) as process:
        yield process


def test_the_script_runs_the_code_of_the_clone_in_its_folder(process: PeerProcess, peer: Peer) -> None:
    """What the peer prints does not disturb the answers, and a large array fits both ways."""
    cells = np.arange(600_000).reshape(600, 1000)
    told = process.ask("double", cells=cells)
    assert np.array_equal(told["cells"], 2 * cells)
    assert told["folder"] == told["path"] == str(peer.folder.resolve())
    assert told["pid"] != os.getpid()
    assert process.ask("double", cells=cells[:1])["pid"] == told["pid"]
    assert process.ask("ours")["loaded"] == []
    assert process.versions == {"numpy": np.__version__}
    assert list(peer.folder.rglob("__pycache__")) == []


@pytest.mark.parametrize(
    ("question", "values", "told"),
    [
        ("die", {"code": 3}, "ended with exit code 3; it printed: doubling | Killed by the peer | last words"),
        pytest.param("kill", {}, "was killed by SIGKILL; it printed: loading", marks=pytest.mark.slow),
        ("close", {}, "closed its output"),
        ("garble", {}, "sent what is no answer: expected a message that begins with b'IXP1', got b'Segmentation fau'"),
        ("fail", {}, "failed in 'fail': ValueError: no path to node 3"),
        pytest.param("wrong", {}, "failed in 'wrong': no answer", marks=pytest.mark.slow),
        ("unsendable", {}, "expected a JSON value or an array of numbers, got a object"),
        pytest.param("unheard", {}, "failed in 'unheard': KeyError: 'unheard'", marks=pytest.mark.slow),
    ],
)
def test_a_failure_is_one_line_and_the_next_question_finds_a_new_process(
    process: PeerProcess, question: str, values: dict[str, int], told: str
) -> None:
    first = process.ask("double", cells=np.ones(1))["pid"]
    with pytest.raises(PeerFailure) as failed:
        process.ask(question, **values)
    assert f"the process of clone {told}" in str(failed.value) or told in str(failed.value)
    assert "\n" not in str(failed.value)
    wait_until(lambda: not runs(first), 10.0)
    assert process.ask("double", cells=np.ones(1))["pid"] != first


def test_a_peer_that_hangs_is_ended_with_what_it_started(peer: Peer) -> None:
    with PeerProcess(replace(peer, time_limit=0.5)) as process:
        process.start()
        child = process.ask("start_another")["pid"]
        assert runs(child)
        begun = time.monotonic()
        with pytest.raises(PeerFailure, match=r"gave no answer within 0\.5 s; it printed: loading \| started"):
            process.ask("hang")
        assert time.monotonic() - begun < 10
        wait_until(lambda: not runs(child), 10.0)


def test_a_peer_that_does_not_read_a_long_question_is_ended(peer: Peer) -> None:
    """A question that does not fit the pipe cannot make this process wait for ever."""
    with PeerProcess(replace(peer, time_limit=0.5)) as process:
        process.ask("ours")
        os.kill(process.ask("double", cells=np.ones(1))["pid"], 19)
        with pytest.raises(PeerFailure, match=r"gave no answer within 0\.5 s"):
            process.ask("double", cells=np.ones(1_000_000))


def test_no_process_is_left_when_this_one_is_killed(peer: Peer) -> None:
    """Neither the peer nor what it started outlives a command that was killed."""
    source = f"""
import sys, time
from pathlib import Path
from indoor_explorers.planners.toolbox.peers.process import Peer, PeerProcess
peer = Peer(interpreter=sys.executable, folder=Path({str(peer.folder)!r}), script=Path({str(peer.script)!r}))
process = PeerProcess(peer)
print(process.ask("start_another")["pid"], process._running._process.pid, flush=True)
process.ask("hang")
"""
    with subprocess.Popen([sys.executable, "-c", source], stdout=subprocess.PIPE, text=True) as command:
        assert command.stdout is not None
        pids = [int(word) for word in command.stdout.readline().split()]
        assert all(map(runs, pids))
        command.kill()
    wait_until(lambda: not any(map(runs, pids)), 10.0)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            {"interpreter": "/no/such/python"},
            "/no/such/python: expected a Python interpreter, cannot start it",
        ),
        ({"interpreter": "false"}, "got the process of clone ended with exit code 1; give the one of the peer's"),
        ({"interpreter": "echo"}, "got the process of clone sent what is no answer: expected a message"),
        ({"needs": (Need(package="scikit-image", module="skimage_x"),)}, "expected 'scikit-image' for "),
        ({"needs": (Need(package="numpy", below=1),)}, f"found numpy {np.__version__}; run `{sys.executable} -m pip"),
    ],
    ids=["no file", "it ends", "it is no Python", "a missing package", "a version that does not do"],
)
def test_a_wrong_environment_is_told_in_one_line(peer: Peer, change: dict[str, Any], told: str) -> None:
    with PeerProcess(replace(peer, **change)) as process, pytest.raises(InputError) as refused:
        process.start()
    assert told in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_module_that_is_missed_later_is_told_with_its_package(peer: Peer) -> None:
    needs = (Need(package="pip"), Need(package="image-tools", module="skimage_that_is_not_there"))
    with PeerProcess(replace(peer, needs=needs[:1])) as process, pytest.raises(InputError) as refused:
        process.ask("lack")
    assert "found no module 'skimage_that_is_not_there'; run `" in str(refused.value)
    assert Need(package="numpy", below=2).met_by("1.26.4")
    assert Need(package="numpy", below=2).met_by("")
    assert not Need(package="numpy", below=2).met_by("2.0.1")
