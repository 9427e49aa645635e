"""Policies for the tests that cheat: they use hidden knowledge, or change what they may only read."""

import contextlib
import gc
import itertools
import resource
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from indoor_explorers.env import Pilot, World, conformance, make_policy
from indoor_explorers.env.conformance import suite
from indoor_explorers.evaluation.harness.episodes import running
from indoor_explorers.planners.random_walk import RandomWalk
from tests.evaluation.failing import Breaks
from tests.evaluation.honest import Still, Wander, Wanderer
from tests.seeds import seed_of


class Leaks(Wander):
    """Let all pilots look at one counter, and say too much."""

    class Mind(Wanderer):
        calls = np.zeros(1, int)

        def act(self, view):
            self.message = [float(view.step)]
            self.calls += 1
            return int(np.flatnonzero(view.legal)[self.calls[0] // 3 % view.legal.sum()])


class KnowsMap(Wander):
    """Find the seed by trying small ones, and plan on the map that it draws."""

    def pilot(self, briefing):
        world = World(briefing.scenario)
        world.reset([seed_of(briefing)])
        return make_policy("reference").pilot(world.briefing(0, briefing.agent, privileged=True))


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


@dataclass(frozen=True)
class Vandal(Breaks):
    """Write to what it may only read, in one of the ways there are."""

    way: str

    def break_down(self, view):
        WAYS[self.way](view.belief)
        raise AssertionError("that worked")


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


@dataclass(frozen=True)
class Searches(Wander):
    """Search its process for the world, the map and the seed; fail if there is one of them."""

    seed: int

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


class ClaimsPrivilege(Wander):
    """Say that it is privileged, and fail if it is given the map."""

    privileged = True

    def pilot(self, briefing):
        assert briefing.truth is None
        return super().pilot(briefing)


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
        return super().pilot(briefing)


class Teleports(Wander):
    """Change what its own steps do in its process."""

    def pilot(self, briefing):
        begin = World.__dict__["step"]
        World.step = lambda world, actions: begin(world, 0 * actions)
        return super().pilot(briefing)


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
            sides = (below, self.known[:, :column], above, self.known[:, column + 1 :])
            unknown = [(side == 0).sum() for side in sides]
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
