"""The policy ``tours``, which flies as the DDDQN does without its network."""

from pathlib import Path

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, InputError, Policy, Scenario, World, make_policy
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.policy import Dddqn
from indoor_explorers.learners.dddqn.tours import Tours
from tests.learners.dddqn.rooms import write_network


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
def test_tours_fly_as_the_dddqn_does_without_its_network(name: str, steps: int, tmp_path: Path) -> None:
    weights = "thesis-obstacles"
    if name == "small-cave":
        candidates = ObservationConfig(tours=False, prospects=True)
        weights = write_network(tmp_path / "weights.safetensors", 1, candidates)
    plain = Dddqn(weights=weights, network=False, guard=False)
    for seed in (1, 2):
        assert moves(Tours(guard=False), PRESETS[name], seed, steps) == moves(plain, PRESETS[name], seed, steps)
    assert moves(Tours(guard=False), PRESETS[name], 1, steps) != moves(Dddqn(guard=False), PRESETS[name], 1, steps)


def test_states_delay_and_map_prior_change_the_tours() -> None:
    room = PRESETS["thesis-obstacles"]
    every = Tours(), Tours(states=2), Tours(delay=0.1), Tours(map_prior=False)
    assert len({tuple(moves(each, room, 4, 45)) for each in every}) == 4
    assert moves(Tours(delay=1e-9), room, 4, 45) == moves(Tours(), room, 4, 45)


def test_the_provenance_and_the_limits_of_tours() -> None:
    assert make_policy("tours", states=64) == Tours(states=64)
    assert len(Tours().provenance()["map_prior_sha256"]) == 64
    assert Tours(map_prior=False).provenance() == {}
    assert range(1_000_000, 1_000_500) in Tours().seen_seeds()["tuning"]  # the number of states was chosen after these
    for wrong in (0, 2000, 2.5):
        with pytest.raises(InputError, match=r"expected states from 1 to 1024, got"):
            Tours(states=wrong)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"expected delay from 0 to 1, got -1"):
        Tours(delay=-1)
