"""Parameters that make no sense are refused by name, whatever the policy."""

from __future__ import annotations

from math import inf, nan, nextafter
from typing import Any

import pytest

from indoor_explorers.env import InputError
from indoor_explorers.env.policies.registry import policy_class
from indoor_explorers.planners.toolbox.parameters import Bounds, Parameters, declared
from tests.behaviour.policies import POLICIES

INFORMED = "indoor_explorers.planners.frontier.informed:FrontierInformed"
KINDS = {name: policy_class(name) for name in (*POLICIES, INFORMED)}
CHECKED = {name: kind for name, kind in KINDS.items() if issubclass(kind, Parameters)}
EVERY = [(name, key) for name, kind in CHECKED.items() for key in declared(kind)]


@pytest.mark.parametrize(("name", "key"), EVERY)
def test_values_out_of_bounds_are_refused(name: str, key: str) -> None:
    kind: type[Any] = CHECKED[name]
    allowed = declared(kind)[key]
    if isinstance(allowed, Bounds):
        wrong = [nextafter(allowed.least, -inf), nextafter(allowed.most, inf), nan, "1"]
        expected = f"{kind.__name__}: expected {key} of at least {allowed.least:g}"
    else:
        wrong, expected = ["anything"], f"expected {key} to be one of {', '.join(allowed)}, got 'anything'"
    for value in wrong:
        with pytest.raises(InputError, match=expected):
            kind(**{key: value})


def test_nearly_every_number_of_a_planner_has_bounds() -> None:
    assert len(CHECKED) >= 25
    assert len(EVERY) >= 250
    lengths = [declared(policy_class(name))["decay_length"] for name in ("frontier-latency", "pso", "rrt-aep")]
    assert lengths == [Bounds(0.01, inf), Bounds(1e-6, inf), Bounds(0.01, inf)]
    assert declared(policy_class("rrt-aep"))["samples"] == Bounds(1, inf)  # where only the default is another one
