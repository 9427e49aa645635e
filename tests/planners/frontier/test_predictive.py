from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from indoor_explorers.env import InputError, Policy, World, make_policy, scenario
from indoor_explorers.env.provenance import RECORD
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.planners.toolbox.networks.weights_file import write_weights_file
from indoor_explorers.planners.toolbox.pockets.estimates import NAME
from indoor_explorers.planners.toolbox.pockets.network import shapes


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


def coverage(policy: Policy) -> list[int]:
    """The coverage after each step of a UAV on a small floor."""
    world = World(scenario("small-floors").with_settings({"team": 1}))
    world.reset([5])
    return [
        int(world.team_coverage[0] * 1e6) for _ in rollout(world, ask_pilots(policy, make_pilots(policy, world), world))
    ]


@pytest.mark.parametrize("name", ["frontier-predictive", "pso-predictive", "rrt-predictive", "dddqn-places"])
def test_it_flies_with_the_weights_of_another_training(name: str, tmp_path: Path) -> None:
    flat = {key: np.zeros(shape, np.float32) for key, shape in shapes().items()}  # a half for each probability
    write_weights_file(tmp_path / NAME, flat, {})
    (tmp_path / RECORD).write_text(json.dumps({"seen_maps": {"training": ["dungeons/train"]}}))
    shipped, other = make_policy(name), make_policy(name, pocket_weights=str(tmp_path))
    assert coverage(other) != coverage(shipped)
    assert other.provenance()["pocket_weights"] != shipped.provenance()["pocket_weights"]
    assert "dungeons/train" in other.seen_maps()["training"]
    with pytest.raises(InputError, match="elsewhere"):
        make_policy(name, pocket_weights=str(tmp_path / "elsewhere"))


def test_the_paper_s_revenue_has_no_estimates() -> None:
    with pytest.raises(InputError, match="expected as_published=false"):
        make_policy("rrt-predictive", as_published=True)
