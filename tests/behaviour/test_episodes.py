"""The tests of policies fly what they claim to, and find a policy that misbehaves."""

from __future__ import annotations

import shlex
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from indoor_explorers.env import make_policy, policy_names
from indoor_explorers.env.policies.registry import policy_entry_points
from indoor_explorers.evaluation.harness.episodes.record import Outcome
from tests.behaviour.covering import pairwise
from tests.behaviour.episodes import LOST_UAV, Case, FailureCase, violations
from tests.behaviour.policies import ALIASES, CLASSES, POLICIES
from tests.behaviour.soak import cases, parser
from tests.behaviour.worlds import FACTORS, KINDS, WORLDS, covering_array

ROOM: dict[str, Any] = {"world": "room", "source": "thesis-obstacles", "seed": 0}


def pairs(rows: list[dict[str, Any]]) -> set[Any]:
    return {pair for row in rows for pair in combinations(row.items(), 2)}


@pytest.mark.parametrize("factors", [FACTORS, {"a": (1, 2), "b": (1, 2, 3), "c": (1, 2)}, {"a": (1, 2), "b": (3,)}])
def test_every_two_settings_meet_in_a_row(factors):
    wanted = {
        ((one, x), (other, y)) for one, other in combinations(factors, 2) for x in factors[one] for y in factors[other]
    }
    assert pairs(pairwise(factors)) == wanted


def test_a_covering_array_is_short_and_holds_every_world():
    rows = covering_array()
    assert len(rows) <= 12
    assert {row["world"] for row in rows} == {world for worlds in KINDS.values() for world in worlds}
    assert WORLDS.keys() - {row["world"] for row in rows} == {"offices", "maze", "plus"}  # flown elsewhere
    assert rows == covering_array()


def test_the_policies_are_installed():
    assert CLASSES.keys() <= set(policy_names())


def test_aliases_point_at_the_policy_that_they_stand_for():
    assert {name: policy_entry_points()[name].value for name in CLASSES} == CLASSES
    for alias, name in ALIASES.items():
        assert CLASSES[alias] == CLASSES[name]
        assert make_policy(alias) == make_policy(name)
    assert len({CLASSES[name] for name in POLICIES}) == len(POLICIES) == len(CLASSES) - len(ALIASES)


def test_what_misbehaves_is_found():
    still = Case("tests.evaluation.plugins:Still", **ROOM, team=2, settings={"budget": 60})
    assert [problem.split()[0] for problem in violations(still.fly())] == ["covered", "longest"]
    assert "indoor-explorers watch --policy tests.evaluation.plugins:Still" in still.command()
    wrong = Case("tests.evaluation.plugins:WrongAction", **ROOM, team=1, settings={})
    assert violations(wrong.fly())[0].startswith("failed: ")


def test_what_does_not_finish_a_failure_mode_is_found():
    still = FailureCase("tests.evaluation.plugins:Still", "mate-in-doorway", "none", seed=3)
    assert still.problems()[0].startswith("unfinished: UAV ")
    assert still.command().endswith("--modes mate-in-doorway --radios none --seed 3")
    arguments = parser().parse_args(shlex.split(still.command())[3:])
    assert list(cases(arguments)) == [still]


def test_a_lost_uav_has_ended_and_the_others_fly_on():
    record = Case(f"{LOST_UAV}:frontier-nearest", **ROOM, team=3, settings={"on_collision": "end"}).fly()
    alone = Case("frontier-nearest", **ROOM, team=3, settings={"on_collision": "end"}).fly()
    assert record.outcome is Outcome.COMPLETE
    assert record.metrics["collisions"] == 1
    assert np.array_equal(record.actions[:5], alone.actions[:5])
    assert (record.actions[-1] != 4).sum() <= 2
    assert not make_policy(f"{LOST_UAV}:pso").privileged


def test_a_command_names_the_map_file_and_every_setting(map_files: Path):
    case = Case.on("comb", map_files, "pso", 2, {"radio.model": "none"}, seed=3)
    words = case.command().split()
    assert words[:6] == ["indoor-explorers", "watch", "--policy", "pso", "--maps", str(map_files / "comb.npy")]
    assert {"radio.model=none", "lidar.range=2", "budget=4000"} <= set(words)
    assert case.scenario.team == 2
