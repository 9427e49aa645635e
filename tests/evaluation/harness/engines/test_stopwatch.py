"""A process is believed when it decides and when it compiles, as far as that is possible."""

import pytest

from indoor_explorers.evaluation.harness.engines import stopwatch
from indoor_explorers.evaluation.harness.engines.stopwatch import Stopwatch
from indoor_explorers.evaluation.harness.episodes.shared_memory import COMPILED, ENDED, Clock


@pytest.fixture
def timed(monkeypatch):
    """A clock, its stopwatch, and a function that lets time pass during which threads are busy for some of it."""
    clock, busy = Clock(), [0.0]
    watch = Stopwatch(clock)
    monkeypatch.setattr(stopwatch, "busy_time", lambda pid: busy[0])
    monkeypatch.setattr(stopwatch.time, "monotonic", iter(range(0, 10**9, 1000)).__next__)

    def after(seconds, running=0.0):
        busy[0] += running
        return watch.seconds(seconds, 0)[0]

    return clock, watch, after


def test_decisions_that_end_start_it_anew_as_often_as_there_are_some(timed):
    clock, watch, after = timed
    watch.ask(2)
    assert [after(1.0), after(1.0)] == [1.0, 2.0]
    for ended, waited in ((1.0, 0.0), (1.0, 1.0), (0.0, 2.0), (float("nan"), 3.0), (9.0, 4.0), (2.0, 0.0), (3.0, 1.0)):
        clock._times[ENDED] = ended
        assert after(1.0) == waited


def test_a_stopped_clock_does_not_stop_it(timed):
    clock, watch, after = timed
    watch.ask(1)
    after(0.0)
    clock._times[:] = memoryview(bytes(48)).cast("d")
    assert [after(1.0), after(1.0)] == [1.0, 2.0]


def test_where_the_process_is_trusted_it_is_the_clock_of_decisions(timed):
    clock, _, after = timed
    assert after(1.0) == 0.0
    with clock:
        assert [after(1.0), after(1.0)] == [0.0, 1.0]
    assert after(1.0) == 0.0


def test_compiling_counts_only_while_it_is_asleep_and_not_for_ever(timed):
    clock, watch, after = timed
    watch.ask(1)
    assert after(1.0) == 1.0
    clock._times[COMPILED] += 4.0
    assert after(2.0, running=1.5) == 0.5
    clock._times[COMPILED] += 4.0
    assert after(0.5, running=0.2) == 1.0, "mostly asleep"
    clock._times[COMPILED] = float("inf")
    assert after(0.5) == 1.5
    assert after(1.0, running=1.0) == 2.5, "nothing more was compiled"
    clock._times[COMPILED] = 0.0
    assert after(1.0) == 3.5
    for compiled, waited in ((450.0, 0.0), (900.0, 450.0)):
        clock._times[COMPILED] = compiled
        assert after(450.0, running=450.0) == waited
