"""Policies for the tests that raise, exit, hang or take all memory."""

import contextlib
import ctypes
import itertools
import os
import signal
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from tests.evaluation.honest import Batched, Wander, Wanderer
from tests.seeds import seed_of


class Raises(Wander):
    class Mind(Wanderer):
        def act(self, view):
            if view.step == 5 and view.cell[0] % 2:
                raise RuntimeError("motor</script>\nfailure")
            return super().act(view)


class WrongAction(Wander):
    class Mind(Wanderer):
        def act(self, view):
            return 5


class Dies(Wander):
    def pilot(self, briefing):
        os._exit(3)


class NeverMade(Wander):
    def __init__(self):
        raise RuntimeError("no\nweights")


class Breaks(Wander):
    """Fly as Wander does, but break at step 5 on odd seeds; the seed is found by trying."""

    class Mind(Wanderer):
        def __init__(self, briefing, policy):
            super().__init__(briefing)
            self.policy = policy
            self.guilty = seed_of(briefing) % 2 == 1

        def act(self, view):
            if self.guilty and view.step == 5:
                self.policy.break_down(view)
            return super().act(view)

    def pilot(self, briefing):
        return self.Mind(briefing, self)

    def break_down(self, view):
        raise NotImplementedError


def hang_for_good(seconds=0.01):
    """Swallow every interruption."""
    while True:
        with contextlib.suppress(BaseException):
            time.sleep(seconds)


class HangsInSleep(Breaks):
    def break_down(self, view):
        while True:
            with contextlib.suppress(Exception):  # as a careless retry loop would
                time.sleep(0.01)


class HangsInPython(Breaks):
    def break_down(self, view):
        while True:
            pass


class HangsForGood(Breaks):
    def break_down(self, view):
        hang_for_good()


class HangsInC(Breaks):
    """Keep the interpreter's lock: nothing else of the process runs, no signal is handled."""

    def break_down(self, view):
        sum(itertools.repeat(1))


class HangsTogether(HangsInPython):
    """One forward pass for all, which hangs as soon as a guilty UAV takes part in it."""

    batched, act = True, Batched.act


class HangsAtTheStart(Wander):
    def pilot(self, briefing):
        if seed_of(briefing) % 2:
            time.sleep(60)
        return super().pilot(briefing)


class HangsWhenDeleted(Wander):
    class Mind(Wanderer):
        def __del__(self):
            hang_for_good()


@dataclass(frozen=True)
class HangsInCAndTellsWhere(Wander):
    """Write the number of its process to a file, and keep the interpreter's lock."""

    where: str

    def pilot(self, briefing):
        Path(self.where).write_text(str(os.getpid()))
        sum(itertools.repeat(1))


def of_the_process(name):
    """Return a variable of the code that calls the policy."""
    frame = sys._getframe()
    while name not in frame.f_locals:
        frame = frame.f_back
    return frame.f_locals[name]


@dataclass(frozen=True)
class Deceives(Breaks):
    """Hang in a way that those who wait for it may not notice."""

    way: str

    def break_down(self, view):
        answers, clock = of_the_process("connection").fileno(), of_the_process("server")._clock
        if self.way == "stops its worker":
            keeper = Path(f"/proc/{os.getppid()}/stat").read_text()
            os.kill(int(keeper.rpartition(")")[2].split()[1]), signal.SIGSTOP)
        clock.__exit__()
        if self.way == "says that it compiles":
            clock.begin_compiling()
        os.write(answers, {"begins to answer": b"\0\0", "answers slowly": b"\0\0\7\7"}.get(self.way, b""))
        while True:
            with contextlib.suppress(BaseException):
                time.sleep(0.05)
                os.write(answers, b"[" if self.way == "answers slowly" else b"")


class Forks(Wander):
    """Copy its process at each decision; the copies go on."""

    class Mind(Wanderer):
        def act(self, view):
            if len(os.listdir("/proc")) < 1000:  # noqa: PTH208  # a bound where the copies do not end
                os.fork()
            return super().act(view)


class ExitsPython(Breaks):
    def break_down(self, view):
        sys.exit("enough")


class Exits(Breaks):
    def break_down(self, view):
        os._exit(3)


class KillsItself(Breaks):
    def break_down(self, view):
        os.kill(os.getpid(), signal.SIGKILL)


class Segfaults(Breaks):
    def break_down(self, view):
        ctypes.string_at(0)


class ReturnsNothing(Breaks):
    class Mind(Breaks.Mind):
        def act(self, view):
            return "up" if self.guilty and view.step == 5 else super().act(view)


class LeaksAtOnce(Breaks):
    """Take a hundred megabytes and more at each step from the fifth on."""

    HELD: ClassVar[list[object]] = []

    def break_down(self, view):
        pass

    class Mind(Breaks.Mind):
        def act(self, view):
            if self.guilty and view.step >= 5:
                LeaksAtOnce.HELD.append(np.ones(15_000_000))
                time.sleep(0.1)
            return super().act(view)


class LeaksSlowly(Wander):
    """Take a hundred megabytes for each UAV: no single episode is to blame."""

    HELD: ClassVar[list[object]] = []

    def pilot(self, briefing):
        LeaksSlowly.HELD.append(np.ones(12_500_000))
        time.sleep(0.05)
        return super().pilot(briefing)
