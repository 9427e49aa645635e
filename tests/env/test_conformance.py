"""The conformance suite finds what is wrong with a policy and says the likely cause."""

import numpy as np
import pytest

from indoor_explorers.env import Pilot, Policy, PolicyError, World, check_policy


class Honest(Pilot):
    def __init__(self, briefing, policy=None):
        self.briefing, self.policy, self.rng = briefing, policy, briefing.rng

    def act(self, view):
        self.message = tuple(map(float, view.cell))
        return int(self.rng.choice(np.flatnonzero(view.legal[:4])))


class Flying(Policy):
    """A policy with the pilot kind under test."""

    kind = Honest

    def pilot(self, briefing):
        return self.kind(briefing, self)


class WritesView(Honest):
    def act(self, view):
        view.belief[0, 0] = 1
        return 4


class NoAction(Honest):
    def act(self, view):
        return 1.5


class Shouts(Honest):
    def act(self, view):
        self.message = tuple(range(17))
        return 4


class GlobalDraws(Honest):
    def act(self, view):
        return int(np.random.default_rng().choice(np.flatnonzero(view.legal[:4])))


class SharedCounter(Honest):
    def act(self, view):
        self.policy.count = getattr(self.policy, "count", 0) + 1
        return int(np.flatnonzero(view.legal)[self.policy.count % view.legal.sum()])


def make(kind):
    return type(kind.__name__ + "Policy", (Flying,), {"kind": kind, "__reduce__": lambda self: (make, (kind,))})()


def test_an_honest_policy_passes_and_gets_a_report():
    report = check_policy(make(Honest))
    assert set(report) >= {"actions", "messages", "pickling", "no hidden knowledge", "latency"}
    assert "8 changes" in report["no hidden knowledge"]


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        (WritesView, "read-only, copy"),
        (NoAction, "expected an action from 0 to 4"),
        (Shouts, "at most 16 finite numbers"),
        (GlobalDraws, r"draw from briefing\.rng"),
        (SharedCounter, "pilots share state"),
    ],
)
def test_a_broken_policy_is_told_why(kind, message):
    with pytest.raises(PolicyError, match=message):
        check_policy(make(kind))


def test_a_policy_that_cannot_be_pickled_is_told_why():
    policy = make(Honest)
    policy.__class__.__reduce__ = lambda self: (_ for _ in ()).throw(TypeError("cannot pickle a lock"))
    with pytest.raises(PolicyError, match="cannot be pickled"):
        check_policy(policy)


class Omniscient(Honest):
    """Chooses by the number of walls of the true map."""

    def act(self, view):
        return int((self.briefing.truth == 2).sum() % 5)


def test_a_policy_that_knows_the_truth_is_caught(monkeypatch):
    briefing = World.briefing
    monkeypatch.setattr(World, "briefing", lambda self, b, n, privileged: briefing(self, b, n, privileged=True))
    with pytest.raises(PolicyError, match="no UAV had seen"):
        check_policy(make(Omniscient))
