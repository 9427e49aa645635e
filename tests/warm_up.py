"""Compile what the tests run before they start, once: pytest's processes would each compile the same.

    python -m tests.warm_up

The machine code is kept; when nothing has changed, this takes a few seconds.
"""

from __future__ import annotations

import sys

import numpy as np

from indoor_explorers.env import PRESETS, Scenario, World, make_policy
from indoor_explorers.evaluation.episodes.runner import fly
from indoor_explorers.evaluation.experiment.experiment import Task
from tests.behaviour.policies import POLICIES

SHORT = {"budget": 40}
#: A lone UAV, and a team of which some meet.
ROOMS = [
    PRESETS["thesis-obstacles"].for_evaluation().with_settings(SHORT),
    PRESETS["thesis-team-4"].for_evaluation().with_settings({**SHORT, "spawn": "clustered"}),
]


def fly_policies(scenario: Scenario) -> None:
    """Fly one short episode of every policy."""
    for name in POLICIES:
        sys.stdout.write(f"compiling {name}, {scenario.name}\n")
        sys.stdout.flush()
        for _ in fly(make_policy(name), name, scenario, [Task(scenario.name, 0, 0)]):
            pass


def fly_presets() -> None:
    """Fly the world alone on every preset."""
    for scenario in PRESETS.values():
        world = World(scenario, 2)
        world.reset([1, 2])
        world.step(np.zeros((2, scenario.team), np.int64))


if __name__ == "__main__":
    fly_presets()
    for room in ROOMS:
        fly_policies(room)
