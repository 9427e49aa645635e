from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import InputError, Policy, World, make_policy, scenario
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout


def steps_to_99_per_cent(policy: Policy, seed: int) -> int:
    """Return after how many steps a UAV knows 99 % of a small floor."""
    task = scenario("floors").with_settings({"team": 1, "goal": 0.99, "map.area": (600.0, 1500.0)})
    world = World(task)
    world.reset([seed])
    return sum(1 for _ in rollout(world, ask_pilots(policy, make_pilots(policy, world), world)))


@pytest.mark.slow
def test_it_needs_fewer_steps_to_99_per_cent_than_the_order_without_estimates() -> None:
    predictive, latency = make_policy("frontier-predictive"), make_policy("frontier-latency")
    ratios = [steps_to_99_per_cent(predictive, seed) / steps_to_99_per_cent(latency, seed) for seed in range(10)]
    assert np.mean(ratios) < 0.98


def test_it_tells_what_its_estimates_saw() -> None:
    policy = make_policy("frontier-predictive")
    assert policy.seen_maps() == {"training": ["floors/train", "dungeons/train"]}
    assert len(policy.provenance()["pocket_weights"]) >= 12


@pytest.mark.parametrize("name", ["skip", "risk", "visit", "near", "aim", "latency"])
def test_bad_parameters_are_refused(name: str) -> None:
    with pytest.raises(InputError, match=f"expected {name} of at least"):
        make_policy("frontier-predictive", **{name: -1.0})
