"""Compile what the tests run before they start, once: pytest's processes would each compile the same.

    python -m tests.warm_up

The machine code is kept; when nothing has changed, this takes a few seconds.
"""

import sys
from concurrent.futures import ProcessPoolExecutor

import gymnasium
import numpy as np

from indoor_explorers.env import PRESETS, World, make_policy
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from tests.behaviour.policies import POLICIES
from tests.env import plugins

ENVIRONMENT = "indoor_explorers.env:IndoorExplorers-v0"
SHORT = {"budget": 40}
#: A lone UAV, and a team of which some meet.
ROOMS = [
    PRESETS["thesis-obstacles"].for_evaluation().with_settings(SHORT),
    PRESETS["thesis-team-4"].for_evaluation().with_settings({**SHORT, "spawn": "clustered"}),
]


def fly_policy(name: str) -> str:
    """Fly short episodes of a policy."""
    policy = make_policy(name)
    for scenario in ROOMS:
        for _ in fly(policy, name, scenario, [Task(scenario.name, 0, 0)]):
            pass
    return name


def fly_presets() -> None:
    """Fly the world alone on every preset, with the lidar and radio of plug-ins, and with sensors that err."""
    custom = {"lidar.model": f"{plugins.__name__}:exact", "radio.model": f"{plugins.__name__}:disc"}
    erring = {"noise.misses": 0.1}
    for scenario in (*PRESETS.values(), *(ROOMS[1].with_settings(changes) for changes in (custom, erring))):
        world = World(scenario, 2)
        world.reset([1, 2])
        world.step(np.zeros((2, scenario.team), np.int64))


def step_interfaces() -> None:
    """Step the environments of learners."""
    for observation in ("channels", "egocentric"):
        single = gymnasium.make(ENVIRONMENT, observation=observation)
        batch = gymnasium.make_vec(ENVIRONMENT, 2, "vector_entry_point", observation=observation)
        for env in (single, batch):
            env.reset(seed=0)
            env.step(env.action_space.sample())


def main() -> None:
    """Compile, and say for which policies that is done."""
    fly_presets()
    step_interfaces()
    with ProcessPoolExecutor() as pool:  # those with the most to compile first; for a function that both need one waits
        for number, name in enumerate(pool.map(fly_policy, reversed(POLICIES)), start=1):
            sys.stdout.write(f"compiled {name} ({number} of {len(POLICIES)})\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
