"""Shipped policies always look the same, and no two policies of a page look alike."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from indoor_explorers.env import policy_names
from indoor_explorers.evaluation.drawing.palette import GREY, INKS, SHIPPED, policy_styles
from indoor_explorers.evaluation.site.published import SUITE_POLICIES

EXPERIMENTS = Path(__file__).parents[3] / "evaluation" / "experiments"
FACTS = {"random": {"plans_for": "nothing"}, "reference": {"privileged": True}, "optimum": {"privileged": True}}


def test_a_shipped_policy_looks_the_same_whoever_else_flies() -> None:
    alone = {name: policy_styles([name])[name] for name in ("frontier", "frontier-nearest", "dddqn", "pso")}
    assert {name: alone[name].colour for name in alone} == {
        "frontier": 0,
        "frontier-nearest": 1,
        "dddqn": 2,
        "pso": 3,
    }
    together = policy_styles(["mine", *reversed(alone), "theirs", "rrt"])
    assert {name: together[name] for name in alone} == alone


def test_every_shipped_policy_has_a_look_of_its_own() -> None:
    assert {name for names in SHIPPED.values() for name in names} == set(policy_names()) - FACTS.keys()
    styles = policy_styles({name: FACTS.get(name, {}) for name in policy_names()})
    assert len({style[:2] for style in styles.values()}) == len(styles)
    assert styles["random"].colour == GREY
    assert INKS[styles["reference"].colour] == INKS[-1]


def test_policies_of_published_comparisons_differ_in_colour() -> None:
    flown = [tomllib.loads((EXPERIMENTS / f"{name}.toml").read_text())["policies"] for name in ("quick", "families")]
    for policies in (SUITE_POLICIES, *flown):
        names = [each if isinstance(each, str) else each["use"] for each in policies]
        styles = policy_styles({name: FACTS.get(name, {}) for name in names})
        assert len({style.colour for style in styles.values()}) == len(names)


@pytest.mark.parametrize("number", [7, 20])
def test_policies_of_others_get_what_is_left(number: int) -> None:
    styles = policy_styles(["frontier", *(f"mine {k}" for k in range(number - 1))])
    assert len({style[:2] for style in styles.values()}) == number
    assert len({style.colour for style in styles.values()}) == 7
