"""Policies for the tests that keep the contract."""

import os
import sys
import time
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from indoor_explorers.env import Pilot, Policy
from indoor_explorers.evaluation.harness.episodes.shared_memory import Clock


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
    #: The pilot of each UAV.
    Mind: ClassVar[type[Pilot]] = Wanderer

    def pilot(self, briefing):
        return self.Mind(briefing)


class ToldOfTheBase(Wander):
    """Tell how long ago the contacts with the base were, and declare to be done at step 7."""

    class Mind(Wanderer):
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


class ToldOfThePrior(Wander):
    """Tell what is in the prior map."""

    class Mind(Wanderer):
        def __init__(self, briefing):
            super().__init__(briefing)
            assert briefing.truth is None
            self.prior = briefing.prior

        def tally(self):
            prior = self.prior
            return {} if prior is None else {"prior": float(prior.sum()), "fixed": float(not prior.flags.writeable)}


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


class Still(Wander):
    class Mind(Wanderer):
        def act(self, view):
            return 4


class NotesItsEnd(Wander):
    """Note whether the clock ran when it was deleted."""

    CLOCK: ClassVar[Clock]
    TIMED: ClassVar[list[bool]] = []

    def __del__(self):
        self.TIMED.append(self.CLOCK.asked > 0)


class Prints(Wander):
    """Write to the standard output, by Python and to its file descriptor."""

    def pilot(self, briefing):
        sys.stdout.write("noise\n" * 100)
        os.write(1, b"more noise\n")
        return super().pilot(briefing)
