from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import make_policy
from indoor_explorers.planners.swarm.robots import ParticlePilot, PsoRobots
from tests.planners.flights import fly, maze, world_on


def test_pulls_follow_paths_and_pushes_lead_away() -> None:
    free = np.ones((7, 7), np.bool_)
    free[1:, 3] = False
    world = world_on(free, [(5, 2), (5, 1)], team=2, radio__model="unlimited", lidar__range=20.0)
    pilot, view = ParticlePilot(world.briefing(0, 0), PsoRobots()), world.view(0, 0)
    assert pilot._towards(view, (0, 2)).tolist() == [-1.0, 0.0]
    assert pilot._towards(view, None).tolist() == [0.0, 0.0]
    assert pilot._from_walls(view).tolist() == [0.0, -1.0]
    assert pilot._from_mates(view) == pytest.approx([0.0, 1 - 1 / 20])


def test_the_best_sent_frontier_wins() -> None:
    world = world_on(np.ones((1, 31), np.bool_), [(0, 9), (0, 16)], team=2, radio__model="unlimited")
    pilots = [ParticlePilot(world.briefing(0, k), PsoRobots()) for k in range(2)]
    for k, message in enumerate([(0.0, 6.0, 1.0), (0.0, 19.0, 2.0)]):
        pilots[k].message = message
        world.post(0, k, message)
    world.step(np.array([[4, 4]]))
    assert [pilot._best_sent(world.view(0, k)) for k, pilot in enumerate(pilots)] == [(0, 19), (0, 19)]


def test_stagnant_particles_are_split_off() -> None:
    flight = fly(make_policy("pso-robots", stagnation=3), maze(7, 7, 1), lidar=1.0)
    assert flight.complete
    tally = flight.pilots[0].tally()
    assert tally["split_off_steps"] >= tally["splits"] > 0
