"""Checks that an episode is the same when repeated, flown by a copy, beside another one, or in another batch order."""

from __future__ import annotations

import pickle

from indoor_explorers.env.conformance.findings import SHOWN, Differs, Violation, global_generators, shared_state, shown
from indoor_explorers.env.conformance.flying import CheckedFlight, backwards, one_by_one
from indoor_explorers.env.conformance.harness import FIRST, OTHER, SOLO, STEPS, TEAM, Harness
from indoor_explorers.env.conformance.traces import Trace, first_difference
from indoor_explorers.env.errors import described
from indoor_explorers.env.policies.policy import Pilot, Policy


def check_repeatable(harness: Harness) -> str:
    """Fly the same seeds again."""
    for scenario, trace in zip((SOLO, TEAM), harness.alone, strict=True):
        before = global_generators()
        (again,) = harness.fly(scenario, [FIRST])
        drawn = [name for name, state in global_generators().items() if state != before[name]]
        cause = f"the policy draws from the global {' and '.join(drawn)}; " if drawn else ""
        fix = f"{cause}draw from briefing.rng only, keep nothing in the policy, its class or its module"
        _must_be_same(again, trace, "the same seed gave another episode", fix + ("" if drawn else _perhaps(harness)))
    return "yes, one UAV and four"


def check_pickling(harness: Harness) -> str:
    """Fly a pickled copy, as worker processes do."""
    advice = "keep lambdas, open files and locks out of the policy, or load them when a pilot is made"
    try:
        copy = pickle.loads(pickle.dumps(harness.policy))
    except Exception as error:
        found = f"the policy cannot be pickled, as worker processes need it ({described(error, SHOWN)})"
        raise Violation(found, advice) from error
    if not isinstance(copy, Policy):
        raise Violation(f"the policy came back from pickling as {shown(copy)}", "fix its __reduce__ or __getstate__")
    (again,) = harness.fly(TEAM, [FIRST], policy=copy)
    advice = "let everything that it needs be pickled with it, or be loaded when a pilot is made"
    _must_be_same(again, harness.alone[1], "a pickled copy flew another episode", advice)
    return "a copy flies the same episode"


def check_independent(harness: Harness) -> str:
    """Fly an episode beside another one."""
    fix = "keep state in the pilot and not in the policy, its class or a default argument"
    fix += ", and in a batched act let no episode look at another" if harness.batched else ""
    found = "an episode flown beside another one came out differently: pilots share state"
    _must_be_same(harness.beside[0], harness.alone[1], found, fix + _perhaps(harness))
    return "yes, an episode is the same beside another one"


def check_order(harness: Harness) -> str:
    """Ask the same UAVs in another order, and each in a call of its own."""
    ways = [("in reverse order", backwards)] + [("one by one", one_by_one)] * harness.batched
    for way, ask in ways:
        for found, expected in zip(harness.fly(TEAM, [FIRST, OTHER], ask=ask), harness.beside, strict=True):
            fix = "let no choice depend on the place in the batch or on the other views of it"
            fix += ", as batch normalisation in training mode makes it do" if harness.batched else ""
            _must_be_same(found, expected, f"UAVs asked {way} chose differently", fix + _perhaps(harness))
    return f"the same {' and '.join(way for way, _ in ways)}"


def check_explanations(harness: Harness) -> str:
    """Ask the pilots of an episode to explain each action."""
    alone = harness.alone[1]  # which tells the class of the pilots
    if getattr(harness.pilot, "explain", None) is Pilot.explain:
        return "none given"
    flight = CheckedFlight(harness.policy, harness.sized(TEAM), [FIRST], explaining=True)
    (told,) = flight.fly(STEPS)
    fix = "let nothing that act computes depend on explaining, and let explain change nothing"
    _must_be_same(told, alone, "pilots that were asked to explain their actions chose differently", fix)
    return f"{flight.explained} of {len(told.seconds)} actions, which asking did not change"


def _perhaps(harness: Harness) -> str:
    return shared_state(harness.policy, harness.pilot)


def _must_be_same(found: Trace, expected: Trace, what: str, fix: str) -> None:
    step = first_difference(found, expected)
    if step is not None:
        raise Differs(f"{what} (first difference at step {step})", fix)
