"""What all planners on viewpoints have in common, and what is special about those with a memory."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from indoor_explorers.env import make_policy
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.policies.view import Mate, View
from tests.planners.flights import fly, rooms, view_of, world_on

PLANNERS = ["rrt-frontier", "rrt-nbv", "rrt-aep", "prm-tour"]
#: Those whose flights, of two seeds each, are compared between processes: of every kind of tree and roadmap.
JOBS = [(name, seed) for name in (*PLANNERS, "rrt-star") for seed in (1, 2)]
EPISODES = """
from tests.planners.sampling.test_viewpoints import JOBS, episode
print([episode(*job) for job in JOBS[::-1]])
"""


def episode(name: str, seed: int) -> str:
    policy = make_policy("rrt-aep", take_turns=True) if name == "rrt-star" else make_policy(name)
    flight = fly(policy, rooms(2, 4, 3), team=2, radio=("disc", 6.0), seed=seed, budget=40)
    return hashlib.sha256(repr(flight.actions).encode()).hexdigest()


@pytest.mark.slow
def test_episodes_do_not_depend_on_process_or_order() -> None:
    here = [episode(*job) for job in JOBS]
    done = subprocess.run([sys.executable, "-c", EPISODES], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == (f"{here[::-1]}\n", "")
    assert len(set(here)) == len(here)


def pilot_and_view(name: str, mates: tuple[Mate, ...] = ()) -> tuple[Any, View]:
    world = world_on(np.ones((9, 30), np.bool_), [(4, 2), (4, 3)], team=2, radio__model="unlimited")
    pilot = make_policy(name).pilot(world.briefing(0, 1))
    belief = np.zeros((9, 30), np.uint8)
    belief[:, 10:19] = FREE
    visited = np.zeros(belief.shape, np.bool_)
    visited[4, 14] = True
    return pilot, view_of(belief, (4, 14), mates)._replace(visited=visited)


@pytest.mark.parametrize("name", PLANNERS)
def test_a_linked_mate_and_its_claim_are_left_alone(name: str) -> None:
    pilot, view = pilot_and_view(name)
    pilot.act(view)
    row, col = map(int, pilot.message)
    other, view = pilot_and_view(name, (Mate(0, (4, 13 if col < 14 else 15), 0, (float(row), float(col))),))
    other.act(view)
    assert (other.message[1] < 14) != (col < 14)
