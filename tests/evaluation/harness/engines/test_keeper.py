"""Processes that a policy starts count as its own and end with it, whatever they do to stay."""

import subprocess
import sys

import pytest

from indoor_explorers.evaluation.harness.engines.keeper import CROWDED
from indoor_explorers.evaluation.harness.engines.process_tree import ProcessTree, process_of
from tests.processes import wait_until

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="other systems do not tell of processes")

#: A process that is kept, starts a process that leaves its session and its parent, and then does what it is told to.
KEPT = """
import ctypes, os, signal, sys, time
from multiprocessing import Pipe
from indoor_explorers.evaluation.harness.engines.keeper import begin_kept

begin_kept(os.getppid(), Pipe()[0], most=5)
if os.fork() == 0:
    os.setsid()
    ctypes.CDLL(None).prctl(1, 0)
    if os.fork():
        os._exit(0)
    os.close(1)
    time.sleep(60)
    os._exit(0)
os.wait()
print(os.getpid(), flush=True)
if sys.argv[1] == "breeds":
    for _ in range(10):
        os.fork() or time.sleep(60)
if sys.argv[1] == "finds its keeper":
    os.kill(os.getppid(), signal.SIGSTOP)
if sys.argv[1] == "ends":
    os._exit(3)
if sys.argv[1] == "is killed":
    os.kill(os.getpid(), signal.SIGKILL)
time.sleep(60)
"""


def kept(what):
    """Start it; return its keeper and all that the keeper keeps."""
    keeper = subprocess.Popen([sys.executable, "-P", "-c", KEPT, what], stdout=subprocess.PIPE)
    tree = ProcessTree(keeper.pid)
    if what in ("waits", "finds its keeper"):
        assert int(keeper.stdout.readline()) in tree.update()
        wait_until(lambda: len(tree.update()) == 2)
    return keeper, tree


@pytest.mark.parametrize(("what", "code"), [("ends", 3), ("is killed", -9), ("breeds", CROWDED)])
def test_what_a_process_started_ends_with_it_and_its_keeper_ends_as_it_did(what, code):
    keeper, tree = kept(what)
    with keeper:
        assert keeper.wait(30.0) == code
        assert not tree.update()
        keeper.stdout.read()


def test_it_ends_with_the_parent_of_the_keeper_however_that_ends():
    script = f"import subprocess, sys\nsubprocess.run([sys.executable, '-P', '-c', {KEPT!r}, 'waits'])"
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE) as parent:
        parent.stdout.readline()
        tree = ProcessTree(parent.pid)
        assert len(tree.update()) == 3
        parent.kill()
        wait_until(lambda: not tree.update())


def test_all_are_found_and_killed_also_when_the_keeper_is_stopped_or_gone():
    keeper, tree = kept("finds its keeper")
    with keeper:
        wait_until(lambda: process_of(keeper.pid).state == "T")
        keeper.kill()
        keeper.wait()
        wait_until(lambda: len(tree.update()) == 1)  # one that asked to outlive its parents
        assert tree.kill()
        wait_until(lambda: not tree.update())


MEASURES = """
import os, signal, time
from indoor_explorers.evaluation.harness.engines.process_tree import memory_of

before = memory_of([os.getpid()])
file = os.memfd_create("hidden")
os.posix_fallocate(file, 0, 50_000_000)
assert 49e6 < memory_of([os.getpid()]) - before < 60e6
os.close(file)
held = bytearray(b"x") * 50_000_000
child = os.fork() or time.sleep(60)
assert 49e6 < memory_of([os.getpid(), child]) - before < 60e6
assert memory_of([os.getpid(), child], 10**12) > before + 2 * len(held)
os.kill(child, signal.SIGKILL)
os.waitpid(child, 0)
"""


def test_memory_counts_once_mapped_or_not():
    """In a small process of its own: from a large idle one, the system may take pages back in the meantime."""
    subprocess.run([sys.executable, "-P", "-c", MEASURES], check=True)
