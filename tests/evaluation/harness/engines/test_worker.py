"""What runs in a worker process, without the process."""

import subprocess
import sys

import numba
import numpy as np
import pytest
from numba.core import event

from indoor_explorers.evaluation.harness.episodes.shared_memory import Clock, DecisionTimeout, SharedStepBuffer
from indoor_explorers.evaluation.harness.episodes.steps import step_type
from indoor_explorers.evaluation.harness.episodes.thinking_time import Compiling


def test_compiling_is_not_put_down_to_a_decision():
    clock = Clock()
    listener = Compiling(clock)
    event.register("numba:compile", listener)
    try:
        with clock:
            asked = clock.asked
            assert numba.njit(lambda x: x + 1)(1) == 2
            assert (clock.asked, first := clock.compiled) > (asked, 0.0)
        assert clock.compiled == first, "nothing is compiled now"
        assert numba.njit(lambda x: x + 2)(1) == 3
        assert clock.compiled > first
    finally:
        event.unregister("numba:compile", listener)


def test_compiling_counts_where_numba_has_other_events():
    code = """
from numba.core import event
del event.TimingListener
from indoor_explorers.evaluation.harness.episodes.shared_memory import Clock
from indoor_explorers.evaluation.harness.episodes.thinking_time import note_compiling, thinking_time
note_compiling(Clock())
print(thinking_time() < thinking_time())
"""
    told = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, check=True)
    assert told.stdout == "True\n"


def test_only_the_overdue_decision_is_interrupted_and_only_once():
    clock = Clock()
    with clock:
        marked = clock.asked
    clock.mark_overdue(marked, 2.5)
    clock.interrupt()
    with clock:
        clock.interrupt()
        clock.mark_overdue(clock.asked, 2.5)
        with pytest.raises(DecisionTimeout, match=r"decision took longer than 2.5 s \(--decision-timeout\)"):
            clock.interrupt()
        clock.interrupt()


def test_a_step_buffer_holds_whole_steps():
    buffer = SharedStepBuffer()
    assert buffer.steps(2).steps == 0
    for step in range(3):
        row = np.zeros((), step_type(2))
        row["actions"], row["seconds"], row["sent"] = (step, 4), step / 2, 10 * step
        buffer.add(row[()])
    steps = buffer.steps(2)
    assert steps.actions.tolist() == [[1, 4], [2, 4]]
    assert steps.seconds.tolist() == [0.0, 0.5, 1.0]
    assert steps.sent.tolist() == [0, 10, 20]
    buffer.begin()
    assert buffer.steps(2).steps == 0
    buffer.close()
