"""Small scenes and choices for the tests."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import World, make_policy, scenario
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.learners.places.flights import DISCOUNT, ChoiceArrays
from indoor_explorers.learners.places.options import OPTION_COMMON, Options
from indoor_explorers.learners.places.scene import COMMON, MOST, PLACE, Scene
from indoor_explorers.learners.places.truth import TRUE_COMMON, TRUE_PLACE


def world_on_a_floor(
    seed: int = 3,
    steps: int = 60,
    team: int = 1,
    settings: Mapping[str, Any] = MappingProxyType({}),
    flown_by: str = "frontier-nearest",
) -> World:
    """A world in which UAVs have flown for some steps over a small floor, with more settings if any."""
    world = World(scenario("small-floors").with_settings({"team": team, "goal": 0.99, **settings}))
    world.reset([seed])
    policy = make_policy(flown_by)
    for _, _ in zip(range(steps), rollout(world, ask_pilots(policy, make_pilots(policy, world), world)), strict=False):
        pass
    return world


def random_scene(count: int, seed: int = 0) -> Scene:
    rng = np.random.default_rng(seed)
    places, common = rng.normal(size=(count, PLACE)).astype(np.float32), rng.normal(size=COMMON).astype(np.float32)
    costs = rng.uniform(0.0, 5.0, count).astype(np.float32)
    steps, between = rng.uniform(0.0, 3.0, count), np.zeros((count, count))
    return Scene(np.arange(count, dtype=np.int32), places, common, costs, np.arange(count), steps, between)


def with_some_options(scene: Scene) -> Scene:
    """With two options of three, and the rules' values of these."""
    numbers = np.random.default_rng(7).normal(size=OPTION_COMMON).astype(np.float32)
    return scene.with_options(Options(numbers, np.array([0.5, -np.inf, 2.0], np.float32)))


def random_choices(count: int, there: int = 3, uav: int = 4) -> ChoiceArrays:
    """ChoiceArrays among ``there`` places with even odds, ``uav`` of each UAV, one UAV to a flight."""
    rng = np.random.default_rng(1)
    is_there = np.broadcast_to(np.arange(MOST) < there, (count, MOST)).copy()
    arrays: dict[str, NDArray[Any]] = {
        "places": np.where(is_there[..., None], rng.normal(size=(count, MOST, PLACE)), 0.0).astype(np.float16),
        "common": rng.normal(size=(count, COMMON)).astype(np.float32),
        "there": is_there,
        "costs": np.zeros((count, MOST), np.float32),
        "true_places": np.zeros((count, MOST, TRUE_PLACE), np.float16),
        "true_common": rng.normal(size=(count, TRUE_COMMON)).astype(np.float32),
        "probabilities": (is_there / there).astype(np.float32),
        "chosen": rng.integers(there, size=count),
        "rewards": -rng.uniform(0.5, 1.5, count).astype(np.float32),
        "durations": rng.uniform(0.5, 2.0, count).astype(np.float32),
        "discounts": np.full(count, DISCOUNT, np.float32),
    }
    flights = count // uav
    return ChoiceArrays(arrays, np.full(flights, uav), np.arange(flights), rng.uniform(1.0, 3.0, (flights, 2)))
