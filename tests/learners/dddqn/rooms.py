"""Maps, beliefs and settings that the learners' tests share."""

from collections import deque
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from indoor_explorers.env import PRESETS, Policy, Scenario, World
from indoor_explorers.env.grid.arrays import Belief, Mask
from indoor_explorers.env.maps import Floorplan
from indoor_explorers.env.sensing.lidar import scan
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.learners.dddqn.config import TrainingConfig
from indoor_explorers.learners.dddqn.network.config import NetworkConfig
from indoor_explorers.learners.dddqn.network.model import arrays, new_network
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import observation_layout
from indoor_explorers.learners.dddqn.observation.map_prior import MapPrior, prior_arrays, prior_from
from indoor_explorers.learners.dddqn.weights import write_weights
from indoor_explorers.learners.sessions.checkpoint import CHECKPOINT
from indoor_explorers.planners.toolbox.networks.tensors import read_tensors

#: A network that is quick to make.
NARROW = NetworkConfig(width=32, move_width=4)

#: A training of a few seconds.
TINY = TrainingConfig(
    network=NARROW,
    device="cpu",
    prior_notes=2_000,
    total_steps=600,
    environments=4,
    warmup_steps=40,
    batch=16,
    replay_steps=400,
    evaluation_every=300,
    evaluation_episodes=3,
    checkpoint_every=200,
)


def small_room(obstacles: int = 2) -> Scenario:
    """An 8x8 room with a short budget."""
    return PRESETS["thesis-open"].with_settings(
        {"map.height": 8, "map.width": 8, "map.obstacles": obstacles, "budget": 60}
    )


def random_belief(rng: np.random.Generator, height: int = 13, width: int = 18) -> tuple[Belief, tuple[int, int]]:
    """What three scans from the same part of a random map tell, and one of their cells."""
    truth = np.where(rng.random((height, width)) < 0.2, 2, 1).astype(np.uint8)
    cells = [tuple(cell) for cell in rng.permutation(np.argwhere(truth == 1))[:3].tolist()]
    belief = np.maximum.reduce([scan(truth, cell, 3.0) for cell in cells])
    return belief, cells[0]


def maze(rng: np.random.Generator, rooms: int = 8) -> Mask:
    """A maze of corridors one cell wide, (2 rooms + 1) cells a side, without loops."""
    free = np.zeros((2 * rooms + 1, 2 * rooms + 1), np.bool_)
    free[1, 1] = True
    trail = deque([(1, 1)])
    while trail:
        row, col = trail[-1]
        ways = [(2, 0), (-2, 0), (0, 2), (0, -2)]
        ways = [
            (r, c)
            for r, c in ways
            if 0 < row + r < len(free) and 0 < col + c < len(free) and not free[row + r, col + c]
        ]
        if not ways:
            trail.pop()
            continue
        r, c = ways[rng.integers(len(ways))]
        free[row + r // 2, col + c // 2] = free[row + r, col + c] = True
        trail.append((row + r, col + c))
    return free


def cells_flown(policy: Policy, world: World) -> NDArray[np.int64]:
    """Fly the episodes of a world that have begun to their ends; return the cells (T, B, N, 2) after each step."""
    flight = rollout(world, ask_pilots(policy, make_pilots(policy, world), world))
    return np.array([world.state.cell.copy() for _ in flight])


def fly(policy: Policy, scenario: Scenario, seed: int, free: Mask | None = None) -> World:
    """Fly one episode to its end, over a map with these free cells (H, W) if they are given."""
    world = World(scenario)
    world.begin(0, seed, floorplan=None if free is None else Floorplan.from_free(free, "test"))
    cells_flown(policy, world)
    return world


def assert_same_checkpoints(one: Path, other: Path) -> None:
    """Demand that the checkpoints of two folders hold the same arrays and the same other state."""
    (tensors, state), (others, other_state) = (read_tensors(folder / CHECKPOINT) for folder in (one, other))
    assert state == other_state
    assert tensors.keys() == others.keys()
    for name, array in tensors.items():
        assert np.array_equal(array, others[name]), name


def some_prior(seed: int = 0) -> MapPrior:
    """A map prior that says something about every patch."""
    rng = np.random.default_rng(seed)
    return prior_from(
        {
            "prior.hidden": rng.normal(size=(147, 16)),
            "prior.hidden_bias": rng.normal(size=16),
            "prior.out": rng.normal(size=16),
            "prior.out_bias": rng.normal(size=1),
        }
    )


def write_network(path: Path, seed: int, observation: ObservationConfig | None = None) -> str:
    """Write the weights of an untrained network."""
    sight = observation or ObservationConfig()
    network = new_network(observation_layout(sight), NARROW, seed)
    write_weights(path, arrays(network), prior_arrays(some_prior(seed)), sight, NARROW)
    return str(path)


@pytest.fixture
def untrained(tmp_path: Path) -> str:
    """The path of the weights of an untrained network."""
    return write_network(tmp_path / "untrained.safetensors", 3)
