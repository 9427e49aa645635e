"""The search space: from the fields of a policy, with ranges of one's own, and what is refused."""

import dataclasses
from argparse import ArgumentTypeError

import pytest

from indoor_explorers.env import InputError, Policy
from indoor_explorers.env.policies.registry import policy_class, policy_names
from indoor_explorers.env.policies.tunable import Choices, Span, tunable_parameters
from indoor_explorers.evaluation.harness.experiment.experiment import PolicyChoice
from indoor_explorers.evaluation.studies.tuning.request import read_range
from indoor_explorers.evaluation.studies.tuning.space import SearchSpace
from tests.behaviour.policies import ALIKE, parametrized

#: The families that are tuned, and fewest parameters of each.
TUNED = {
    **{"frontier": 8, "frontier-latency": 6, "frontier-predictive": 8, "frontier-utility": 4, "frontier-burgard": 3},
    **{"rrt": 8, "rrt-frontier": 6, "rrt-nbv": 6, "rrt-predictive": 6, "prm-tour": 6, "cover-tour": 6},
    **{"pso": 8, "pso-predictive": 8, "pso-robots": 6, "gso": 7, "aco": 8, "bat": 8, "hedac": 2, "sgba": 2},
    **{"pomdp": 6, "horizon": 4},
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class PlugIn(Policy):
    """A policy that needs nothing of this project but the base class."""

    near: float = dataclasses.field(default=0.5, metadata={"tunable": (0.1, 2.0, "log")})
    count: int = dataclasses.field(default=3, metadata={"tunable": (1, 9)})
    order: str = dataclasses.field(default="left", metadata={"tunable": ["left", "right"]})
    plain: float = 1.0

    def pilot(self, briefing):
        raise NotImplementedError


@dataclasses.dataclass(frozen=True, kw_only=True)
class Heir(PlugIn):
    """Repeats a field with another default, and withdraws another one."""

    near: float = 1.0
    count: int = dataclasses.field(default=3, metadata={"tunable": None})


@dataclasses.dataclass(frozen=True, kw_only=True)
class Wrong(PlugIn):
    """Declares a range that is none."""

    near: float = dataclasses.field(default=0.5, metadata={"tunable": (0.0, 2.0, "log")})


def space(use, *asked, **fixed):
    return SearchSpace.of(PolicyChoice(use=use, name=use, parameters=fixed), [read_range(each) for each in asked])


def test_a_plug_ins_fields_declare_its_ranges_and_a_repeated_default_keeps_them():
    declared = tunable_parameters(PlugIn)
    assert declared == {
        "near": Span(0.1, 2.0, log=True),
        "count": Span(1, 9, whole=True),
        "order": Choices(["left", "right"]),
    }
    assert tunable_parameters(Heir) == {name: declared[name] for name in ("near", "order")}
    with pytest.raises(InputError, match=r"parameter 'near': expected a range .* got \(0.0, 2.0, 'log'\)"):
        tunable_parameters(Wrong)


@parametrized([name for name in policy_names() if tunable_parameters(policy_class(name))], slow=ALIKE)
def test_every_shipped_range_has_the_default_in_it_and_ends_that_the_policy_takes(name):
    found = space(name)
    assert len(found.ranges) >= TUNED.get(name, 1)
    assert all(found.defaults[key] in each for key, each in found.ranges.items())


def test_the_families_declare_ranges():
    assert {name for name in TUNED if tunable_parameters(policy_class(name))} == set(TUNED)


def test_what_is_fixed_stays_and_ranges_asked_for_take_precedence():
    found = space("frontier-utility", "reach=0.5:3", "form=size,discounted", cost=2.0)
    assert "cost" not in found.ranges
    assert found.ranges["reach"] == Span(0.5, 3)
    assert found.ranges["form"] == Choices(["size", "discounted"])
    made = found.with_parameters("trial-1", {"reach": 1.23456789})
    assert made.parameters == {"cost": 2.0, "reach": 1.235}
    assert found.with_parameters("x", {"reach": 2.9999999}).parameters["reach"] <= 3


def test_a_parameter_without_a_declared_range_can_be_named():
    assert space("horizon", "width=50:200:log").ranges["width"] == Span(50, 200, log=True, whole=True)


@pytest.mark.parametrize(
    ("use", "asked", "fixed", "said"),
    [
        ("frontier-nearest", (), {}, "'frontier-nearest' declares no parameters to tune$"),
        ("reference", (), {}, "'reference' declares no parameters to tune; name some of .*restarts.* with --range"),
        ("frontier-utility", ("reech=1:2",), {}, "no parameter 'reech' to tune; did you mean 'reach'"),
        ("frontier-utility", ("reach=1:2",), {"reach": 1.0}, "'reach', which 'frontier-utility' fixes"),
        ("frontier-utility", ("reach=2:4",), {}, "expected a range of 'reach' with its default 1.0 in it, got 2 to 4"),
        ("frontier-utility", ("reach=4:2",), {}, "parameter 'reach': expected a range"),
        ("frontier-utility", ("reach=-1:2",), {}, "expected reach of at least 0, got -1"),
        ("frontier-utility", ("form=size,sise",), {}, "expected form to be one of .* got 'sise'"),
        ("frontier", ("clusters=4.5:40",), {}, "parameter 'clusters': expected .* whole numbers"),
        ("frontier", ("near=2:20:lin",), {}, "parameter 'near': expected a range"),
    ],
)
def test_what_makes_no_sense_is_refused_in_a_line(use, asked, fixed, said):
    with pytest.raises(InputError, match=said) as refused:
        space(use, *asked, **fixed)
    assert "\n" not in str(refused.value)


def test_a_range_is_read():
    assert read_range("a=1:20:log") == ("a", (1, 20, "log"))
    assert read_range("a=0.5:2") == ("a", (0.5, 2))
    assert read_range("a=x,y") == ("a", ["x", "y"])
    for wrong in ("a", "a=", "=1:2"):
        with pytest.raises(ArgumentTypeError, match="expected name=low:high"):
            read_range(wrong)
