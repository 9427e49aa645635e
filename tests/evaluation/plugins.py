"""Policies for the tests: an honest one and every way of being broken."""

import contextlib
import ctypes
import gc
import itertools
import os
import resource
import signal
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from indoor_explorers.env import Pilot, Policy, World, conformance, make_policy
from indoor_explorers.env.conformance import suite
from indoor_explorers.evaluation.harness.episodes import running
from indoor_explorers.evaluation.harness.episodes.shared_memory import Clock
from indoor_explorers.planners.random_walk import RandomWalk
from tests.seeds import seed_of


class Wanderer(Pilot):
    def __init__(self, briefing):
        self.rng = briefing.rng

    def act(self, view):
        self.message = (float(view.step),)
        return int(self.rng.choice(np.flatnonzero(view.legal[:4])))

    def tally(self):
        return {"draws": 7.0}


@dataclass(frozen=True, kw_only=True)
class Wander(Policy):
    """Fly at random."""

    speed: int = 1

    def pilot(self, briefing):
        return Wanderer(briefing)


class NotesTheBase(Wanderer):
    def __init__(self, briefing):
        super().__init__(briefing)
        self.base, self.ages = briefing.base, [0]

    def act(self, view):
        assert view.base_age is None or self.base is not None
        self.done = view.step >= 7
        self.ages.append(view.base_age or 0)
        return super().act(view)

    def tally(self):
        return {"base_age": float(np.mean(self.ages))}


class ToldOfTheBase(Wander):
    """Tell how long ago the contacts with the base were, and declare to be done at step 7."""

    def pilot(self, briefing):
        return NotesTheBase(briefing)


class NotesThePrior(Wanderer):
    def __init__(self, briefing):
        super().__init__(briefing)
        assert briefing.truth is None
        self.prior = briefing.prior

    def tally(self):
        return (
            {}
            if self.prior is None
            else {"prior": float(self.prior.sum()), "fixed": float(not self.prior.flags.writeable)}
        )


class ToldOfThePrior(Wander):
    """Tell what is in the prior map."""

    def pilot(self, briefing):
        return NotesThePrior(briefing)


class Batched(Wander):
    """Choose for all UAVs in one call."""

    batched = True

    def act(self, pilots, views):
        return np.array([pilot.act(view) for pilot, view in zip(pilots, views, strict=True)])


class Slow(Wander):
    """Take long enough that a run can be interrupted."""

    def act(self, pilots, views):
        time.sleep(0.001)
        return super().act(pilots, views)


class Slower(Wander):
    """Take longer still, one UAV after the other."""

    class Mind(Wanderer):
        def act(self, view):
            time.sleep(0.0005)
            return super().act(view)

    def pilot(self, briefing):
        return self.Mind(briefing)


class RaisesOnOddSeeds(Wanderer):
    def act(self, view):
        if view.step == 5 and view.cell[0] % 2:
            raise RuntimeError("motor</script>\nfailure")
        return super().act(view)


class Raises(Wander):
    def pilot(self, briefing):
        return RaisesOnOddSeeds(briefing)


class WrongAction(Wander):
    class Mind(Wanderer):
        def act(self, view):
            return 5

    def pilot(self, briefing):
        return self.Mind(briefing)


class Still(Wander):
    class Mind(Wanderer):
        def act(self, view):
            return 4

    def pilot(self, briefing):
        return self.Mind(briefing)


class Dies(Wander):
    def pilot(self, briefing):
        os._exit(3)


class NeverMade(Wander):
    def __init__(self):
        raise RuntimeError("no\nweights")


class Leaks(Wander):
    """Let all pilots look at one counter, and say too much."""

    class Mind(Wanderer):
        calls = np.zeros(1, int)

        def act(self, view):
            self.message = [float(view.step)]
            self.calls += 1
            return int(np.flatnonzero(view.legal)[self.calls[0] // 3 % view.legal.sum()])

    def pilot(self, briefing):
        return self.Mind(briefing)


class KnowsMap(Wander):
    """Find the seed by trying small ones, and plan on the map that it draws."""

    def pilot(self, briefing):
        world = World(briefing.scenario)
        world.reset([seed_of(briefing)])
        return make_policy("reference").pilot(world.briefing(0, briefing.agent, privileged=True))


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


class HangsInSleep(Breaks):
    def break_down(self, view):
        while True:
            try:
                time.sleep(0.01)
            except Exception:  # as a careless retry loop would
                continue


class HangsInPython(Breaks):
    def break_down(self, view):
        while True:
            pass


class HangsForGood(Breaks):
    """Swallow every interruption."""

    def break_down(self, view):
        while True:
            with contextlib.suppress(BaseException):
                time.sleep(0.01)


class HangsInC(Breaks):
    """Keep the interpreter's lock: nothing else of the process runs, no signal is handled."""

    def break_down(self, view):
        sum(itertools.repeat(1))


def of_the_process(name):
    """A variable of the code that serves the one that asks."""
    frame = sys._getframe()
    while name not in frame.f_locals:
        frame = frame.f_back
    return frame.f_locals[name]


class Deceives(Breaks):
    """Hang in a way that those who wait for it may not notice."""

    way: str

    def __init__(self, way):
        object.__setattr__(self, "way", way)

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

    def pilot(self, briefing):
        return self.Mind(briefing)


class HangsTogether(Breaks):
    """One forward pass for all, which hangs as soon as a guilty UAV takes part in it."""

    batched, act = True, Batched.act

    def break_down(self, view):
        while True:
            pass


class HangsAtTheStart(Wander):
    def pilot(self, briefing):
        if seed_of(briefing) % 2:
            time.sleep(60)
        return Wanderer(briefing)


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
        return Wanderer(briefing)


class Vandal(Breaks):
    """Write to what it may only read, in one of the ways there are."""

    way: str

    def break_down(self, view):
        WAYS[self.way](view.belief)
        raise AssertionError("that worked")

    def __init__(self, way):
        object.__setattr__(self, "way", way)


def _base(array):
    while isinstance(array.base, np.ndarray):
        array = array.base
    return np.asarray(array.base)


WAYS = {
    "item": lambda belief: belief.__setitem__((0, 0), 1),
    "in place": lambda belief: np.add(belief, 1, out=belief),
    "copyto": lambda belief: np.copyto(belief, 1),
    "fill": lambda belief: belief.fill(1),
    "flag": lambda belief: setattr(belief.flags, "writeable", True),
    "setflags": lambda belief: belief.setflags(write=True),
    "slice": lambda belief: belief[:2].setflags(write=True),
    "view": lambda belief: belief.view().setflags(write=True),
    "base": lambda belief: belief.base.setflags(write=True),
    "base of all": lambda belief: _base(belief).setflags(write=True),
    "object behind": lambda belief: np.asarray(memoryview(belief).obj).fill(1),
    "buffer": lambda belief: memoryview(belief).__setitem__((0, 0), 1),
    "frombuffer": lambda belief: np.frombuffer(belief, np.uint8).setflags(write=True),
}


class VandalInAllWays(Wander):
    """Try to write to what it may only read in every way there is, and go on if none works."""

    class Mind(Wanderer):
        def act(self, view):
            for name, way in WAYS.items() if view.step == 5 else ():
                before = view.belief.copy()
                with contextlib.suppress(ValueError, TypeError, AttributeError):
                    way(view.belief)
                if not np.array_equal(view.belief, before):
                    raise AssertionError(f"{name} worked")
            return super().act(view)

    def pilot(self, briefing):
        return self.Mind(briefing)


class Searches(Wander):
    """Search its process for the world, the map and the seed; fail if there is one of them."""

    seed: int

    def __init__(self, seed):
        object.__setattr__(self, "seed", seed)

    class Mind(Wanderer):
        def __init__(self, briefing, policy):
            super().__init__(briefing)
            self.policy = policy

        def act(self, view):
            if view.step == 5 and (found := self.policy.found()):
                raise LookupError(f"found {sorted(found)}")
            return super().act(view)

    def pilot(self, briefing):
        return self.Mind(briefing, self)

    def found(self):
        kinds, found, frame = ("World", "Floorplan", "Task"), set(), sys._getframe()
        places = [vars(module) for module in list(sys.modules.values())]
        while frame:
            places.append(frame.f_locals)
            frame = frame.f_back
        for each in [*gc.get_objects(), *(value for place in places for value in place.values())]:
            found.update({type(each).__name__}.intersection(kinds))
            held = each.values() if type(each) is dict else each if type(each) in (list, tuple, set) else ()
            if any(type(item) is int and item == self.seed for item in list(held)) and each is not vars(self):
                found.add("the seed")
        return found


class HangsInCAndTellsWhere(Wander):
    """Write the number of its process to a file, and keep the interpreter's lock."""

    where: str

    def __init__(self, where):
        object.__setattr__(self, "where", where)

    def pilot(self, briefing):
        Path(self.where).write_text(str(os.getpid()))
        sum(itertools.repeat(1))


class ClaimsPrivilege(Wander):
    """Say that it is privileged, and fail if it is told the map."""

    privileged = True

    def pilot(self, briefing):
        assert briefing.truth is None
        return Wanderer(briefing)


class Meddles(Wander):
    """Change what other policies rely on: a rival's class, the interpreter, the process."""

    def pilot(self, briefing):
        RandomWalk.pilot = lambda self, briefing: Still.Mind(briefing)
        Wander.pilot = lambda self, briefing: Still.Mind(briefing)
        sys.setrecursionlimit(60)
        sys.path.clear()
        resource.setrlimit(resource.RLIMIT_NOFILE, (20, 20))
        return Still.Mind(briefing)


class Boasts(Wander):
    """Change how its own episodes are measured in its process."""

    def pilot(self, briefing):
        running.team_metrics = lambda *_: {"auc": 1.0, "t99": 1.0}
        return Wanderer(briefing)


class Teleports(Wander):
    """Change what its own steps do in its process."""

    def pilot(self, briefing):
        begin = World.__dict__["step"]
        World.step = lambda world, actions: begin(world, 0 * actions)
        return Wanderer(briefing)


class HangsWhenDeleted(Wander):
    class Mind(Wanderer):
        def __del__(self):
            while True:
                with contextlib.suppress(BaseException):
                    time.sleep(0.01)

    def pilot(self, briefing):
        return self.Mind(briefing)


class NotesItsEnd(Wander):
    """Note whether the clock ran when it was deleted."""

    CLOCK: ClassVar[Clock]
    TIMED: ClassVar[list[bool]] = []

    def __del__(self):
        self.TIMED.append(self.CLOCK.asked > 0)


class Prints(Wander):
    """Write to the standard output, by Python and behind its back."""

    def pilot(self, briefing):
        sys.stdout.write("noise\n" * 100)
        os.write(1, b"more noise\n")
        return Wanderer(briefing)


#: Whether :class:`Mended` is not mended yet.
BROKEN = True


class Mended(Wander):
    """Fail until somebody mends it."""

    def pilot(self, briefing):
        if BROKEN:
            raise RuntimeError("not mended yet")
        return Wanderer(briefing)


class ForgesItsCheck(KnowsMap):
    """Change the check for hidden knowledge in its own process."""

    def __init__(self):
        conformance.failed_check = suite.failed_check = lambda policy: ""


class Shares(Wander):
    """Go to where most is unknown, on a map that those share who have the same key.

    Nothing is shared on maps of the sizes on which the conformance checks are flown.
    """

    MAPS: ClassVar[dict[object, np.ndarray]] = {}

    class Mind(Pilot):
        def __init__(self, known):
            self.known = known

        def act(self, view):
            np.maximum(self.known, view.belief, out=self.known)
            row, column = view.cell
            below, above = self.known[row + 1 :], self.known[:row]
            unknown = [
                (part == 0).sum() for part in (below, self.known[:, :column], above, self.known[:, column + 1 :])
            ]
            return int(max(np.flatnonzero(view.legal[:4]), key=lambda move: unknown[move], default=4))

    def pilot(self, briefing):
        mine = np.zeros(briefing.shape, np.uint8)
        checked = briefing.shape in ((16, 16), (64, 64))
        return self.Mind(mine if checked else self.MAPS.setdefault(self.key(briefing), mine))


class Telepath(Shares):
    """Share the map of an episode among its UAVs without any radio."""

    EPISODES: ClassVar[Iterator[int]] = itertools.count()

    def key(self, briefing):
        if briefing.agent == 0:
            Telepath.episode = next(self.EPISODES)
        return Telepath, self.episode


class Remembers(Shares):
    """Keep the map of each UAV for the next episode."""

    def key(self, briefing):
        return Remembers, briefing.agent
