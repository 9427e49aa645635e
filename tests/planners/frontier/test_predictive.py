from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import InputError, Policy, World, make_policy, scenario
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout


def steps(policy: Policy, seed: int, goal: float) -> int:
    """Return after how many steps a UAV knows so much of a small floor."""
    task = scenario("floors").with_settings({"team": 1, "goal": goal, "map.area": (600.0, 1500.0)})
    world = World(task)
    world.reset([seed])
    return sum(1 for _ in rollout(world, ask_pilots(policy, make_pilots(policy, world), world)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "without", "goal"),
    [
        ("frontier-predictive", "frontier-latency", 0.99),
        ("pso-predictive", "pso", 0.9),
        ("rrt-predictive", "rrt-frontier", 0.9),
    ],
)
def test_on_most_floors_it_needs_fewer_steps_than_without_estimates(name: str, without: str, goal: float) -> None:
    predictive, other = make_policy(name), make_policy(without)
    ratios = [steps(predictive, seed, goal) / steps(other, seed, goal) for seed in range(10)]
    assert np.median(ratios) < 0.97


@pytest.mark.parametrize("name", ["frontier-predictive", "pso-predictive", "rrt-predictive", "pomdp"])
def test_it_tells_what_its_estimates_saw(name: str) -> None:
    policy = make_policy(name)
    assert policy.seen_maps() == {"training": ["floors/train", "dungeons/train"]}
    assert len(policy.provenance()["pocket_weights"]) >= 12
    assert not policy.uses_generator


def test_the_paper_s_revenue_has_no_estimates() -> None:
    with pytest.raises(InputError, match="expected as_published=false"):
        make_policy("rrt-predictive", as_published=True)
