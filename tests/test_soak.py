"""Every policy that this project registers, now or later, behaves: the quick part of soak_behaviour.py."""

from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import make_policy
from indoor_explorers.evaluation.episodes.record import Outcome

from .policies import PLANNERS
from .soak_behaviour import Case, quick_cases, violations


@pytest.mark.parametrize("policy", sorted(PLANNERS))
def test_nobody_freezes_dithers_crashes_or_leaves_a_map_unexplored(policy, tmp_path):
    found = {case.words(): violations(case.fly()) for case in quick_cases(policy, tmp_path)}
    assert len(found) > 20
    assert {words: problems for words, problems in found.items() if problems} == {}


def test_what_misbehaves_is_found():
    still = Case("tests.evaluation.plugins:Still", "room", "thesis-obstacles", 2, {"budget": 60}, 0)
    assert [problem.split()[0] for problem in violations(still.fly())] == ["covered", "longest"]
    assert "indoor-explorers watch --policy tests.evaluation.plugins:Still" in still.words()
    wrong = Case("tests.evaluation.plugins:WrongAction", "room", "thesis-obstacles", 1, {}, 0)
    assert violations(wrong.fly())[0].startswith("failed: ")


def test_a_lost_uav_has_ended_and_the_others_fly_on():
    case = Case("tests.casualties:frontier-nearest", "room", "thesis-obstacles", 3, {"on_collision": "end"}, 0)
    record = case.fly()
    alone = Case("frontier-nearest", "room", "thesis-obstacles", 3, {"on_collision": "end"}, 0).fly()
    assert record.outcome is Outcome.COMPLETE
    assert record.metrics["collisions"] == 1
    assert np.array_equal(record.actions[:5], alone.actions[:5])
    assert (record.actions[-1] != 4).sum() <= 2
    assert not make_policy("tests.casualties:pso").privileged
