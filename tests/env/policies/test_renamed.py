from __future__ import annotations

import inspect
import pickle
from dataclasses import dataclass, replace
from typing import Any

import pytest

from indoor_explorers.env import InputError, Policy, make_policy
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.renamed import renamed, renamed_parameters
from indoor_explorers.env.policies.view import Briefing


def by(**given: Any) -> dict[str, Any]:
    """Parameters by names that type checkers do not know."""
    return given


@renamed(fast="speed", keen=("eager", "hungry"))
@dataclass(frozen=True, kw_only=True)
class Racer(Policy):
    """A policy whose parameters have other names now."""

    speed: float = 1.0
    eager: float = 0.5
    hungry: float = 0.5

    def pilot(self, briefing: Briefing) -> Pilot:
        raise NotImplementedError


@renamed(lazy="idle")
@dataclass(frozen=True, kw_only=True)
class Walker(Racer):
    """One with an old name of its own."""

    idle: bool = False


def test_an_old_name_is_accepted_with_a_warning_that_tells_the_new_one() -> None:
    with pytest.warns(FutureWarning, match=r"Racer: the parameter 'fast' is now 'speed'; .*up to version 0\.3") as told:
        assert Racer(**by(fast=2.0)) == Racer(speed=2.0)
    assert told[0].filename == __file__
    with pytest.warns(FutureWarning, match="'keen' is now 'eager' and 'hungry'"):
        assert Racer(**by(keen=0.1)) == Racer(eager=0.1, hungry=0.1)


def test_a_subclass_takes_the_old_names_too() -> None:
    assert renamed_parameters(Walker) == {"fast": ("speed",), "keen": ("eager", "hungry"), "lazy": ("idle",)}
    assert renamed_parameters(Racer).keys() == {"fast", "keen"}
    with pytest.warns(FutureWarning) as told:
        assert Walker(**by(fast=2.0, lazy=True)) == Walker(speed=2.0, idle=True)
    assert [str(each.message)[:25] for each in told] == ["Walker: the parameter 'fa", "Walker: the parameter 'la"]


def test_a_parameter_by_both_names_is_refused() -> None:
    with (
        pytest.warns(FutureWarning),
        pytest.raises(InputError, match="Racer: expected 'eager' or its old name 'keen', got both; leave 'keen' out"),
    ):
        Racer(**by(keen=0.1), eager=0.2)


def test_nothing_else_changes() -> None:
    assert list(inspect.signature(Racer).parameters) == ["speed", "eager", "hungry"]
    assert pickle.loads(pickle.dumps(Racer(speed=2.0))) == replace(Racer(), speed=2.0)
    with pytest.raises(TypeError, match="slow"):
        Racer(**by(slow=1.0))


def test_names_of_policies_take_old_parameters() -> None:
    address = f"{__name__}:Racer"
    with pytest.warns(FutureWarning, match="'fast' is now 'speed'"):
        assert make_policy(address, fast=2.0) == Racer(speed=2.0)
    with pytest.raises(InputError, match="unknown parameter 'sped'; did you mean 'speed'"):
        make_policy(address, sped=2.0)
