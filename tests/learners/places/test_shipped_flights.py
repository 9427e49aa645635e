"""What the shipped weights fly: digests of actions, recorded before planners and networks shared their places."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest

from indoor_explorers.env import World, make_policy, scenario
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout

#: Digests of all actions by policy, preset and number of UAVs.
FLOWN = {
    ("dddqn-places", "small-floors", 1): "07a9717b145aba30",
    ("dddqn-places", "small-rooms", 2): "b6dda7b9d829275a",
    ("dddqn", "thesis-team-2", 2): "2ab5ecd33e039c77",
    ("dddqn", "thesis-obstacles", 1): "1568e666f0654ce8",
}


def digest_of(name: str, preset: str, team: int) -> str:
    world = World(scenario(preset).with_settings({"team": team}))
    world.reset([7])
    policy, told = make_policy(name), hashlib.sha256()
    ask = ask_pilots(policy, make_pilots(policy, world), world)
    for actions in rollout(world, ask):
        told.update(np.ascontiguousarray(actions, np.int64).tobytes())
    return told.hexdigest()[:16]


@pytest.mark.parametrize(("name", "preset", "team"), FLOWN)
def test_the_shipped_weights_fly_as_before(name: str, preset: str, team: int) -> None:
    assert digest_of(name, preset, team) == FLOWN[name, preset, team]
