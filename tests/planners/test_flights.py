"""What planners have in common in flight: better than the nearest frontier, fallbacks, messages, extreme parameters."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import pytest

from indoor_explorers.env import make_policy
from indoor_explorers.env.grid.arrays import Cell, Mask
from indoor_explorers.planners.toolbox.navigation.teammates import message_of
from tests.planners.flights import fly, maze, rooms, world_on

FEW_SAMPLES = {"samples": 1, "bias": 0.0, "local_ranges": 0.5}
FEW_TREES = {"local_samples": 1, "global_samples": 1, "bias": 0.0, "edge": 0.5}
NO_PULLS = dict.fromkeys(["cognitive", "social", "obstacles", "inertia"], 0.0)


@lru_cache
def steps(name: str) -> int:
    """The steps of one UAV on eight maps together."""
    maps = [*(rooms(3, 9, seed) for seed in range(4)), *(np.ones((16, 16), np.bool_),) * 4]
    return sum(fly(make_policy(name), free, seed=seed).steps for seed, free in enumerate(maps))


@pytest.mark.parametrize(
    ("name", "share"),
    [
        ("frontier-joint", 0.9),
        *(pytest.param(*each, marks=pytest.mark.slow) for each in (("frontier-latency", 0.95), ("rrt-aep", 0.95))),
        ("reference", 0.9),
    ],
)
def test_it_needs_fewer_steps_than_the_nearest_frontier(name: str, share: float) -> None:
    assert steps(name) < share * steps("frontier-nearest")


@pytest.mark.parametrize("name", ["frontier-joint", "rrt-aep", "rrt-frontier", "prm-tour", "aco", "pomdp", "hedac"])
def test_a_uav_sends_its_goal(name: str) -> None:
    flight = fly(make_policy(name), rooms(3, 5, 1), team=2, radio=("unlimited", 0.0), budget=12)
    for pilot in flight.pilots:
        assert pilot.message == message_of(pilot.goal)


@pytest.mark.parametrize(
    ("name", "parameters", "goal"),
    [
        ("aco", {"greed": 1.0, "repulsion": 0.0}, (0, 17)),
        ("aco", {"greed": 1.0}, (0, 24)),
        ("pomdp", {"dimming": 1.0}, (0, 24)),
    ],
)
def test_it_leaves_a_frontier_to_the_linked_teammate_that_flies_there(
    name: str, parameters: dict[str, Any], goal: Cell
) -> None:
    world = world_on(np.ones((1, 41), np.bool_), [(0, 20), (0, 21)], team=2, radio__model="unlimited")
    world.post(0, 1, (0.0, 17.0))
    world.step(np.array([[4, 4]]))
    pilot: Any = make_policy(name, **parameters).pilot(world.briefing(0, 0))
    pilot.act(world.view(0, 0))
    assert pilot.goal == goal


@pytest.mark.parametrize(
    ("name", "parameters", "free", "how", "figure"),
    [
        ("rrt-aep", FEW_SAMPLES | {"near_samples": 0}, rooms(2, 4, 0), {}, "fallbacks"),
        ("rrt-nbv", FEW_SAMPLES, rooms(2, 4, 0), {}, "fallbacks"),
        ("rrt-frontier", FEW_TREES, maze(4, 4, 0), {}, "fallbacks"),  # samples hardly ever find a corridor's end
        ("gso", {"sensor": 0.0}, rooms(2, 4, 1), {}, "out_of_range"),
        ("pomdp", {"horizon": 4.0}, rooms(2, 6, 1), {"lidar": 2.0}, "out_of_range"),
        ("hedac", {"loss": 1e4}, np.ones((1, 400), np.bool_), {"spawns": [(0, 70)]}, "cold_starts"),
        ("pso-robots", NO_PULLS, maze(4, 4, 1), {}, "splits"),
    ],
)
def test_where_it_finds_nothing_it_flies_to_the_nearest_frontier(
    name: str, parameters: dict[str, Any], free: Mask, how: dict[str, Any], figure: str
) -> None:
    flight = fly(make_policy(name, **parameters), free, budget=2000, **how)
    assert flight.complete
    tally = flight.pilots[0].tally()
    assert 0 < tally[figure] <= tally["plans"]
    assert name != "gso" or tally[figure] == tally["plans"]  # as it senses nothing
    assert name != "pomdp" or tally[figure] < tally["plans"]


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("rrt-frontier", {"as_published": True}),
        ("rrt-aep", {"take_turns": True}),
        ("rrt-nbv", {"discount_rate": 1.0, "isolation": 0.0, "decay_length": 100.0}),
        ("prm-tour", {"as_published": True, "isolation": 0.0}),
        ("aco", {"amount": 0.0}),
        ("aco", {"repulsion": 20.0, "own": 1.0, "evaporation": 0.0}),
        ("aco", {"greed": 0.0}),
        ("bat", {"particles": 1, "rounds": 2, "limit": 1}),
        ("pomdp", {"simulations": 1, "maps": 1, "tree": 1}),
    ],
)
def test_published_forms_and_extreme_parameters_complete_maps(name: str, parameters: dict[str, Any]) -> None:
    policy = make_policy(name, **parameters)
    for free, team in ((maze(5, 6, 1), 1), (rooms(2, 4, 1), 1), (rooms(2, 4, 1), 3)):
        flight = fly(policy, free, team=team, radio=("disc", 6.0), budget=3000)
        assert flight.complete
        assert flight.longest_dither <= 6
