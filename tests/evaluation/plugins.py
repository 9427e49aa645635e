"""Policies for the tests: an honest one and every way of being broken."""

import os
import time
from dataclasses import dataclass

import numpy as np

from indoor_explorers.env import Pilot, Policy


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


class Batched(Wander):
    def act(self, pilots, views):
        return np.array([pilot.act(view) for pilot, view in zip(pilots, views, strict=True)])


class Slow(Wander):
    """Take long enough that a run can be interrupted."""

    def act(self, pilots, views):
        time.sleep(0.001)
        return super().act(pilots, views)


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
