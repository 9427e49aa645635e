"""Checks that an episode is the same again, from a copy, beside another one, and however a batch is put together."""

from __future__ import annotations

import pickle

from indoor_explorers.env.conformance.causes import global_generators, shared_things
from indoor_explorers.env.conformance.findings import Breach, Differs, one_line, shown
from indoor_explorers.env.conformance.flying import backwards, one_by_one
from indoor_explorers.env.conformance.harness import FIRST, OTHER, SOLO, TEAM, Subject
from indoor_explorers.env.conformance.traces import Trace, first_difference
from indoor_explorers.env.policies.policy import Policy


def check_repeatable(subject: Subject) -> str:
    """Fly the same seeds again."""
    for scenario, trace in zip((SOLO, TEAM), subject.alone, strict=True):
        before = global_generators()
        (again,) = subject.fly(scenario, [FIRST])
        drawn = [name for name, state in global_generators().items() if state != before[name]]
        cause = f"the policy draws from the global {' and '.join(drawn)}; " if drawn else ""
        mend = f"{cause}draw from briefing.rng only, keep nothing in the policy, its class or its module"
        _must_be_same(again, trace, "the same seed gave another episode", mend + ("" if drawn else _perhaps(subject)))
    return "yes, one UAV and four"


def check_pickling(subject: Subject) -> str:
    """Fly a pickled copy, as worker processes do."""
    advice = "keep lambdas, open files and locks out of the policy, or load them when a pilot is made"
    try:
        copy = pickle.loads(pickle.dumps(subject.policy))
    except Exception as error:
        found = f"the policy cannot be pickled, as worker processes need it ({type(error).__name__}: {one_line(error)})"
        raise Breach(found, advice) from error
    if not isinstance(copy, Policy):
        raise Breach(f"the policy came back from pickling as {shown(copy)}", "mend its __reduce__ or __getstate__")
    (again,) = subject.fly(TEAM, [FIRST], policy=copy)
    advice = "let everything that it needs be pickled with it, or be loaded when a pilot is made"
    _must_be_same(again, subject.alone[1], "a pickled copy flew another episode", advice)
    return "a copy flies the same episode"


def check_independent(subject: Subject) -> str:
    """Fly an episode beside another one."""
    mend = "keep state in the pilot and not in the policy, its class or a default argument"
    mend += ", and in a batched act let no episode look at another" if subject.batched else ""
    found = "an episode flown beside another one came out differently: pilots share state"
    _must_be_same(subject.beside[0], subject.alone[1], found, mend + _perhaps(subject))
    return "yes, an episode is the same beside another one"


def check_order(subject: Subject) -> str:
    """Ask the same UAVs in another order, and each in a call of its own."""
    ways = [("in reverse order", backwards)] + [("one by one", one_by_one)] * subject.batched
    for way, ask in ways:
        for found, expected in zip(subject.fly(TEAM, [FIRST, OTHER], ask=ask), subject.beside, strict=True):
            mend = "let no choice depend on the place in the batch or on the other views of it"
            mend += ", as batch normalisation in training mode makes it do" if subject.batched else ""
            _must_be_same(found, expected, f"UAVs asked {way} chose otherwise", mend + _perhaps(subject))
    return f"the same {' and '.join(way for way, _ in ways)}"


def _perhaps(subject: Subject) -> str:
    return shared_things(subject.policy, subject.pilot)


def _must_be_same(found: Trace, expected: Trace, what: str, mend: str) -> None:
    step = first_difference(found, expected)
    if step is not None:
        raise Differs(f"{what} (first difference at step {step})", mend)
