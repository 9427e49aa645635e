"""The tours as a policy: what the DDDQN flies without its network."""

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, InputError, Policy, Scenario, World, make_policy
from indoor_explorers.learners.dddqn.policy import Dddqn
from indoor_explorers.learners.dddqn.tours import Tours


def moves(policy: Policy, scenario: Scenario, seed: int, steps: int) -> list[int]:
    """The moves of one UAV that flies a scenario."""
    world = World(scenario.for_evaluation().with_settings({"team": 1}))
    world.reset([seed])
    pilot = policy.pilot(world.briefing(0, 0))
    actions = []
    for _ in range(steps):
        actions.append(int(pilot.act(world.view(0, 0))))
        world.step(np.array([[actions[-1]]]))
    return actions


@pytest.mark.parametrize(("name", "steps"), [("thesis-obstacles", 40), ("small-cave", 25)])
def test_tours_fly_as_the_dddqn_does_without_its_network(name: str, steps: int) -> None:
    weights = {"thesis-obstacles": "thesis-obstacles", "small-cave": "general"}[name]
    plain = Dddqn(weights=weights, network=False, guard=False)
    for seed in (1, 2):
        assert moves(Tours(guard=False), PRESETS[name], seed, steps) == moves(plain, PRESETS[name], seed, steps)
    assert moves(Tours(guard=False), PRESETS[name], 1, steps) != moves(Dddqn(guard=False), PRESETS[name], 1, steps)


def test_more_states_and_the_map_prior_change_the_tours() -> None:
    room = PRESETS["thesis-obstacles"]
    flown = [moves(Tours(guard=False, **other), room, 4, 45) for other in ({}, {"states": 2}, {"map_prior": False})]
    assert len({tuple(each) for each in flown}) == 3


def test_tours_tell_what_they_are_made_of() -> None:
    assert make_policy("tours", states=64) == Tours(states=64)
    assert len(Tours().provenance()["map_prior_sha256"]) == 64
    assert Tours(map_prior=False).provenance() == {}
    assert range(1_000_000, 1_000_500) in Tours().seen_seeds()["tuning"]  # the number of states was chosen after these
    for wrong in (0, 2000, 2.5):
        with pytest.raises(InputError, match=r"expected states from 1 to 1024, got"):
            Tours(states=wrong)  # type: ignore[arg-type]
