"""Golden episodes: what each policy did yesterday it does today, on every machine.

After a change that is meant to change episodes, run this file as a program to write them anew, and say so in the
changelog.
"""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, World, make_policy
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from tests.behaviour.policies import EXHAUSTIVE, POLICIES
from tests.marks import slow

GOLDEN = Path(__file__).parent / "golden.json"
SCENARIOS = ("thesis-open", "thesis-team-2")
SEEDS = (1, 2, 3)


def digest(*arrays):
    """A short hash of integer arrays."""
    return hashlib.sha256(b"".join(np.ascontiguousarray(array, np.int64).tobytes() for array in arrays)).hexdigest()[
        :16
    ]


def flown(policy, scenario, seeds=SEEDS):
    task = PRESETS[scenario].for_evaluation()
    records = fly(make_policy(policy), policy, task, [Task(task.name, 0, seed) for seed in seeds])
    return [{"steps": r.steps, "t90": r.metrics["t90"], "digest": digest(r.covered, r.cells)} for r in records]


def world_alone():
    """The world without policies: seeded actions on every preset."""
    found = {}
    for name, scenario in PRESETS.items():
        world = World(scenario.with_settings({"on_collision": "block"}), 2)
        world.reset([41, 42])
        actions = np.random.default_rng(0).integers(0, 5, (60, 2, scenario.team))
        for step in actions:
            world.step(step)
        state = world.state
        found[name] = digest(state.cell, state.belief, state.covered, state.end, (state.reward * 1000).round())
    return found


def everything():
    return {"world": world_alone()} | {f"{p} {s}": flown(p, s) for p in POLICIES for s in SCENARIOS}


@pytest.fixture(scope="module")
def golden():
    return json.loads(GOLDEN.read_text())


@pytest.mark.parametrize("seeds", [SEEDS[:2], *slow(SEEDS[2:])], ids=["two", "third"])
@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize("policy", [pytest.param(p, marks=[pytest.mark.slow] * (p in EXHAUSTIVE)) for p in POLICIES])
def test_a_policy_flies_its_golden_episodes(policy, scenario, seeds, golden):
    expected = dict(zip(SEEDS, golden[f"{policy} {scenario}"], strict=True))
    assert flown(policy, scenario, seeds) == [expected[seed] for seed in seeds]


def test_the_world_alone_is_what_it_was(golden):
    assert world_alone() == golden["world"]


if __name__ == "__main__":
    GOLDEN.write_text(json.dumps(everything(), indent=1) + "\n")
