"""Policies for the tests of the conformance suite: an honest one, to be broken in one way at a time."""

import numpy as np

from indoor_explorers.env import Pilot, Policy, run_checks
from indoor_explorers.env.conformance import CHECKS

#: All but the failure modes: nine flights of 500 steps each for who flies at random or untrained.
MOST_CHECKS = [name for name in CHECKS if name != "failure modes"]


def passed_checks(policy, names=MOST_CHECKS):
    """What the checks of some names say of a policy that passes them, by name."""
    found = list(run_checks(policy, names))
    assert {finding.name: finding.text for finding in found if finding.error} == {}
    return {finding.name: finding.text for finding in found}


class Honest(Pilot):
    def __init__(self, briefing, policy):
        self.briefing, self.policy, self.rng = briefing, policy, briefing.rng

    def act(self, view):
        self.message = tuple(map(float, view.cell))
        return int(self.rng.choice(np.flatnonzero(view.legal[:4])))


class Named(Policy):
    """A policy with the pilot kind under test, pickled by its state."""

    kind = Honest

    def pilot(self, briefing):
        return self.kind(briefing, self)

    def __reduce__(self):
        return blank, (type(self).__name__,), self.__getstate__()


class Flying(Named):
    """The same, pickled without any state."""

    def __reduce__(self):
        return blank, (type(self).__name__,)


#: The classes that were made, by name: pickled policies find theirs here.
MADE: dict[str, type] = {}


def make(kind, base=Flying):
    """A policy of class ``base`` with pilots of class ``kind``."""
    name = f"{kind.__name__}{base.__name__}"
    MADE[name] = type(name, (base,), {"kind": kind})
    return MADE[name]()


def blank(name):
    """A policy of a class that was made, without calling its constructor."""
    return MADE[name].__new__(MADE[name])
