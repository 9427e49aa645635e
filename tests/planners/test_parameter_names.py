"""One word with one unit for each parameter that planners share, and the words before."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

from indoor_explorers.env import make_policy
from indoor_explorers.env.policies.registry import policy_class, policy_entry_points
from indoor_explorers.env.policies.renamed import renamed_parameters
from indoor_explorers.evaluation.cli.parameters import policy_parameters
from indoor_explorers.evaluation.harness.experiment.policy_facts import policy_facts
from indoor_explorers.evaluation.harness.results.policy_version import version_difference
from indoor_explorers.evaluation.studies.leaderboard.verifying import policy_difference
from indoor_explorers.planners.swarm.pso import Pso
from indoor_explorers.planners.toolbox.parameters import (
    DiscountParameters,
    GainParameters,
    GoalBonusParameters,
    SwitchCostParameters,
)
from tests.behaviour.policies import POLICIES

#: The shared words, what each of their descriptions says of the unit, and who declares them.
SHARED: dict[str, tuple[str, type]] = {
    "decay_length": ("in lidar ranges", GainParameters),
    "discount_rate": ("lidar", DiscountParameters),
    "goal_bonus": ("as a share", GoalBonusParameters),
    "switch_cost": ("in lidar ranges", SwitchCostParameters),
}
#: The words before, and the policies that keep one for something else.
FORMER, KEPT = {"fade", "depth", "rate", "discount", "hold", "global_discount"}, {"horizon": {"depth"}}
#: The parameters of policies as version 0.2 named them, away from their defaults.
GIVEN: list[tuple[str, dict[str, float], dict[str, float]]] = [
    ("frontier-burgard", {"hold": 2.0}, {"switch_cost": 2.0}),
    ("frontier-utility", {"hold": 2.0}, {"switch_cost": 2.0}),
    ("frontier-advantage", {"hold": 2.0}, {"switch_cost": 2.0}),
    ("frontier-hungarian", {"hold": 2.0}, {"switch_cost": 2.0}),
    ("frontier-tour", {"hold": 2.0}, {"switch_cost": 2.0}),
    *(
        (
            name,
            {"depth": 1.0, "discount": 2.0, "hold": 3.0},
            {"decay_length": 1.0, "discount_rate": 2.0, "switch_cost": 3.0},
        )
        for name in (
            *("frontier-latency", "frontier-predictive", "rrt-frontier", "rrt-predictive", "rrt-nbv"),
            *("prm-tour", "cover-tour"),
        )
    ),
    (
        "rrt-aep",
        {"depth": 1.0, "discount": 2.0, "hold": 3.0, "global_discount": 4.0},
        {"decay_length": 1.0, "discount_rate": 2.0, "goal_bonus": 3.0, "switch_cost": 3.0, "global_discount_rate": 4.0},
    ),
    *(
        (name, {"fade": 1.0, "rate": 2.0, "hold": 3.0}, {"decay_length": 1.0, "discount_rate": 2.0, "goal_bonus": 3.0})
        for name in ("frontier-joint", "pso", "pso-predictive", "bat")
    ),
    ("aco", {"depth": 1.0, "rate": 2.0, "hold": 3.0}, {"decay_length": 1.0, "discount_rate": 2.0, "goal_bonus": 3.0}),
    ("pomdp", {"rate": 2.0, "hold": 3.0}, {"discount_rate": 2.0, "goal_bonus": 3.0}),
    ("gso", {"depth": 1.0}, {"decay_length": 1.0}),
]


def as_before(facts: dict[str, Any], old: dict[str, tuple[str, ...]]) -> dict[str, Any]:
    """What version 0.2 stored about a policy."""
    names = {present: former for former, each in old.items() for present in each}
    told = {
        key: {names.get(name, name): text for name, text in facts[key].items()} for key in ("parameters", "defaults")
    }
    return {key: value for key, value in facts.items() if key != "renamed"} | told | {"hash": "another"}


@pytest.mark.parametrize("name", POLICIES)
def test_a_word_has_one_unit_and_no_former_one_is_left(name: str) -> None:
    kind = policy_class(name)
    about = {each.key: each.about for each in policy_parameters(kind)} if dataclasses.is_dataclass(kind) else {}
    assert not FORMER & about.keys() - KEPT.get(name, set())
    for word in SHARED.keys() & about.keys():
        unit, declares = SHARED[word]
        assert unit in about[word]
        assert issubclass(kind, declares)


@pytest.mark.parametrize("name", POLICIES)
def test_who_inherits_parameters_takes_their_old_names(name: str) -> None:
    kind = policy_class(name)
    inherited: set[str] = set().union(*(renamed_parameters(base) for base in kind.__mro__[1:]))
    own = vars(kind).get("renamed_parameters", {})
    assert inherited <= own.keys(), f"decorate {kind.__name__} with @renamed()"


def test_all_old_names_are_tried_here() -> None:
    tried = {name: set(old) for name, old, _ in GIVEN}
    assert {name: set(old) for name in POLICIES if (old := renamed_parameters(policy_class(name)))} == tried


@pytest.mark.parametrize(("name", "old", "new"), GIVEN, ids=[name for name, _, _ in GIVEN])
def test_old_names_make_the_same_policy(name: str, old: dict[str, float], new: dict[str, float]) -> None:
    with pytest.warns(FutureWarning) as told:
        assert make_policy(name, **old) == make_policy(name, **new)
    assert len(told) == len(old)


def test_the_constructor_takes_old_names() -> None:
    given: dict[str, Any] = {"fade": 1.0}
    with pytest.warns(FutureWarning, match="Pso: the parameter 'fade' is now 'decay_length'"):
        assert Pso(**given).decay_length == 1.0


@pytest.mark.parametrize(("name", "old", "new"), GIVEN, ids=[name for name, _, _ in GIVEN])
def test_results_stored_by_old_names_are_of_the_same_policy(
    name: str, old: dict[str, float], new: dict[str, float]
) -> None:
    kind = policy_class(name)
    for given in ({}, new):
        now = policy_facts(make_policy(name, **given), name)
        before = as_before(now, dict(renamed_parameters(kind)))
        assert set(old) <= before["parameters"].keys()
        assert (
            version_difference(before, now) == version_difference(now, before) == policy_difference(before, now) == ""
        )
    other = policy_facts(make_policy(name), name)
    assert all(f"parameters.{word} (" in version_difference(before, other) for word in new)


def test_a_planner_within_a_planner_is_compared_by_present_names_too() -> None:
    now = policy_facts(make_policy("horizon"), "horizon")
    inside = "{'isolation': 8.0, 'fade': 0.5, 'power': 0.5, 'rate': 0.8, 'trust': 0.5, 'order': 1.0, 'latency': 3.0, "
    inside += "'hold': 0.2, 'certainty': 0.5, 'period': 0.1, 'clusters': 32, 'lookouts': 8, 'near': 6, 'firsts': 8, "
    before = {key: value for key, value in now.items() if key != "renamed"}
    for rest, difference in ((12, ""), (13, "parameters.beyond.rest (13 and 12)")):
        told = {key: now[key] | {"beyond": f"{inside}'rest': {rest}}}"} for key in ("parameters", "defaults")}
        assert version_difference(before | told, now) == difference


@pytest.mark.parametrize("name", [name for name, entry in policy_entry_points().items() if "indoor_exp" in entry.value])
def test_a_policy_states_its_aim(name: str) -> None:
    assert make_policy(name).plans_for
