"""The networks that ship compute the same numbers, and fly the same moves, bit for bit, whatever reads their files."""

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from indoor_explorers.env import Policy, Scenario, World, make_policy, scenario
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.learners.dddqn.network.inference import q_values as dddqn_values
from indoor_explorers.learners.dddqn.weights import load_weights as load_dddqn
from indoor_explorers.learners.dddqn.weights import shipped
from indoor_explorers.learners.places.network import load_weights as load_places
from indoor_explorers.learners.places.network import values
from indoor_explorers.learners.places.policy import SHIPPED as PLACES
from indoor_explorers.learners.places.policy import SHIPPED_OPTIONS as PLACES_OPTIONS
from indoor_explorers.learners.reports.network import load_weights as load_reports
from indoor_explorers.learners.reports.network import value as report_value
from indoor_explorers.learners.reports.policy import SHIPPED as REPORTS
from indoor_explorers.learners.reports.situation import NUMBERS, Situation
from indoor_explorers.learners.thesis.inference import SHIPPED as THESIS
from indoor_explorers.learners.thesis.inference import q_values as thesis_values
from indoor_explorers.learners.thesis.inference import trained
from indoor_explorers.learners.thesis.observation import LEVELS
from indoor_explorers.planners.toolbox.pockets.estimates import SHIPPED as POCKETS
from indoor_explorers.planners.toolbox.pockets.estimates import SHIPPED_LEVELS as LEVEL_POCKETS
from indoor_explorers.planners.toolbox.pockets.estimates import load_weights as load_pockets
from indoor_explorers.planners.toolbox.pockets.features import COARSE_LAYERS, FINE_LAYERS, PLAIN, SIDE, Kind
from indoor_explorers.planners.toolbox.pockets.features import LEVELS as OVER_LEVELS
from indoor_explorers.planners.toolbox.pockets.network import outputs
from tests.learners.places.small import random_scene, with_some_options

#: Digests of the outputs for random inputs, by weights.
OUTPUTS = {
    "thesis-open": "db65dbab349d0671",
    "thesis-obstacles": "75db1754fefb3577",
    "thesis-open-map": "7fc05c54915ff94c",
    "thesis-obstacles-map": "f92959ac57855a97",
    "places": "a6402e53dd6a5afe",
    "options": "da92e6a140c1c69b",
    "pockets": "88392fe87dae3ed7",
    "pockets-levels": "e0dc7da09498e240",
    "reports": "a2d97d8397f8989c",
    "rewards-1-stuck-2": "5f8c4e4d9b3bce7b",
}
#: Policy, its parameters, scenario, and the digest of the cells of a short flight.
FLIGHTS: tuple[tuple[str, dict[str, Any], str, str], ...] = (
    ("dddqn", {}, "thesis-open", "2c816530726f0958"),
    ("dddqn", {}, "thesis-obstacles", "270afbe8efd88ac7"),
    ("dddqn", {}, "thesis-team-2", "d38e996e471b6517"),
    ("dddqn", {"map_alone": True}, "thesis-open", "f4dd37d3bf2820da"),
    ("dddqn", {"map_alone": True}, "thesis-obstacles", "0051a28d0211180f"),
    ("dddqn-places", {}, "small-floors", "a5e3d421f9a5aeee"),
    ("dddqn-places", {"options": True}, "small-floors", "a5e3d421f9a5aeee"),
    ("dddqn-thesis", {}, "thesis-obstacles", "b3d2c9d7dff038e7"),
    ("frontier-predictive", {}, "small-floors", "79f57cf18dd0458b"),
    ("frontier-predictive", {"level_weights": "shipped"}, "small-storeys", "5782ac170a78198d"),
)
#: Policy, its parameters, scenario, number of UAVs, and the digest of all actions of a whole flight.
WHOLE_FLIGHTS: tuple[tuple[str, dict[str, Any], str, int, str], ...] = (
    ("dddqn-places", {}, "small-floors", 1, "07a9717b145aba30"),
    ("dddqn-places", {}, "small-rooms", 2, "b6dda7b9d829275a"),
    ("dddqn-places", {"options": True}, "office-base-2", 2, "e6aca53c9d072e79"),
    ("dddqn-reports", {}, "office-base-2", 2, "d35e4f5abf0e8c21"),
    ("dddqn", {}, "thesis-team-2", 2, "2ab5ecd33e039c77"),
    ("dddqn", {}, "thesis-obstacles", 1, "1568e666f0654ce8"),
)


def digest(array: NDArray[np.generic]) -> str:
    return hashlib.sha256(np.ascontiguousarray(array).tobytes()).hexdigest()[:16]


def dddqn_outputs(name: str) -> NDArray[np.float32]:
    loaded, rng, q = load_dddqn(shipped()[name]), np.random.default_rng(1), np.zeros((5, 4), np.float32)
    scenes = rng.integers(0, 256, (5, loaded.layout.inputs)).astype(np.uint8)
    dddqn_values(scenes, rng.random((5, 4, loaded.layout.features), np.float32), loaded.weights, q)
    return q


def thesis_outputs() -> NDArray[np.float32]:
    q, images = np.zeros((5, 4), np.float32), np.random.default_rng(1).integers(0, 5, (5, 1, 16, 16)).astype(np.uint8)
    thesis_values(images, LEVELS, trained(THESIS).weights, q)
    return q


def pocket_outputs(path: Path, kind: Kind) -> NDArray[np.float32]:
    rng = np.random.default_rng(1)
    fine = rng.integers(0, 2, (5, kind.levels * FINE_LAYERS, SIDE, SIDE)).astype(np.uint8)
    coarse = rng.integers(0, 10, (5, kind.levels * COARSE_LAYERS, SIDE, SIDE)).astype(np.uint8)
    return outputs(fine, coarse, rng.random((5, kind.numbers), np.float32), load_pockets(path, kind))


def report_outputs() -> NDArray[np.float32]:
    rows = np.random.default_rng(1).random((5, NUMBERS), np.float32)
    return np.array([report_value(Situation(row, 0.0), load_reports(REPORTS)) for row in rows], np.float32)


def found_outputs(name: str) -> NDArray[np.float32]:
    match name:
        case "places":
            return values(random_scene(5), load_places(PLACES))
        case "options":
            return values(with_some_options(random_scene(5)), load_places(PLACES_OPTIONS))
        case "pockets":
            return pocket_outputs(POCKETS, PLAIN)
        case "pockets-levels":
            return pocket_outputs(LEVEL_POCKETS, OVER_LEVELS)
        case "reports":
            return report_outputs()
        case "rewards-1-stuck-2":
            return thesis_outputs()
        case _:
            return dddqn_outputs(name)


def flight(policy: Policy, task: Scenario) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Yield the actions and the cells of each step."""
    world = World(task)
    world.reset([7])
    for actions in rollout(world, ask_pilots(policy, make_pilots(policy, world), world)):
        yield np.array(actions, np.int64), np.array(world.state.cell, np.int64)


@pytest.mark.parametrize("name", OUTPUTS)
def test_weights_give_the_values_that_they_always_gave(name: str) -> None:
    assert digest(found_outputs(name)) == OUTPUTS[name]


@pytest.mark.parametrize(("policy", "parameters", "name", "expected"), FLIGHTS)
def test_networks_fly_as_they_always_flew(policy: str, parameters: dict[str, Any], name: str, expected: str) -> None:
    short = scenario(name).for_evaluation().with_settings({"budget": 60, "on_collision": "block"})
    cells = [cells for _, cells in flight(make_policy(policy, **parameters), short)]
    assert digest(np.stack(cells)) == expected


@pytest.mark.parametrize(("policy", "parameters", "name", "team", "expected"), WHOLE_FLIGHTS)
def test_networks_choose_as_always_to_the_end_of_a_flight(
    policy: str, parameters: dict[str, Any], name: str, team: int, expected: str
) -> None:
    task = scenario(name).with_settings({"team": team})
    assert digest(np.stack([actions for actions, _ in flight(make_policy(policy, **parameters), task)])) == expected
