"""What runs in a worker process, without the process."""

import numba
import pytest
from numba.core import event

from indoor_explorers.evaluation.engines.worker import Compiling
from indoor_explorers.evaluation.episodes.shared_steps import Clock, DecisionTimeout, SharedStepBuffer


def test_compiling_is_not_put_down_to_a_decision():
    clock = Clock()
    listener = Compiling(clock)
    event.register("numba:compile", listener)
    try:
        with clock:
            asked = clock.asked
            assert numba.njit(lambda x: x + 1)(1) == 2
            assert clock.asked > asked
        assert numba.njit(lambda x: x + 2)(1) == 3
        assert clock.asked == 0.0
    finally:
        event.unregister("numba:compile", listener)


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
    for step in range(3):
        buffer.add([step, 4], 0.5, 10 * step)
    steps = buffer.steps(2)
    assert steps.actions.tolist() == [[0, 4], [1, 4], [2, 4]]
    assert steps.seconds.tolist() == [0.5, 1.0, 1.5]
    assert steps.sent.tolist() == [0, 10, 20]
    buffer.begin()
    assert len(buffer.steps(2).actions) == 0
    buffer.close()
