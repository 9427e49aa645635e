from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.planners.swarm.assignment import Plan, fitness
from indoor_explorers.planners.swarm.bat import Bat, echolocated, fly_bat, look_around
from tests.planners.swarm.test_particles import seeded, seeds_of, some_task


def found(bats: Bat, seed: int, task: int = 0, uavs: int = 4) -> Plan:
    problem = some_task(task, uavs, 12)
    rng = np.random.default_rng(seed)
    return echolocated(problem, 3, seeds_of(problem), bats.particles, bats.rounds, bats.rules, rng)


def test_a_bat_flies_towards_the_best_by_its_frequency() -> None:
    speed, out = np.array([0.1, 0.0, 0.0]), np.empty(3)
    fly_bat(np.array([0.2, 0.5, 0.9]), speed, np.array([0.6, 0.5, 0.0]), 0.5, out)
    assert speed == pytest.approx([0.3, 0.0, -0.45])
    assert out == pytest.approx([0.5, 0.5, 0.45])
    fly_bat(np.array([0.9]), np.array([0.5]), np.array([0.9]), 1.0, out[:1])
    assert out[0] == 1.0


def test_a_look_around_stays_near_the_best() -> None:
    out = np.empty(3)
    look_around(np.array([0.5, 0.5, 0.95]), np.array([0.0, 0.75, 1.0]), 0.2, out)
    assert out == pytest.approx([0.3, 0.6, 1.0])


@pytest.mark.parametrize("uavs", [1, 4])
@pytest.mark.parametrize("task", range(6))
def test_the_plan_is_no_worse_than_the_initial_ones(task: int, uavs: int) -> None:
    problem = some_task(task, uavs, 12)
    initial = max(fitness(problem, plan) for plan in seeded(problem, 3))
    assert fitness(problem, found(Bat(), 1, task, uavs)) >= initial


def test_more_rounds_find_fitter_plans() -> None:
    def mean(rounds: int) -> float:
        return float(np.mean([fitness(some_task(k, 4, 12), found(Bat(rounds=rounds), k, k)) for k in range(12)]))

    assert mean(0) < mean(5) < mean(60)


def test_silent_bats_keep_the_best_plan_and_scouts_need_no_loudness() -> None:
    silent = Bat(loudness=1e-6, stride=0.0, limit=1000)
    problem = some_task(3, 4, 12)
    plans = {tuple(found(silent, k, 3).ravel().tolist()) for k in range(4)}
    assert all(fitness(problem, np.array(plan).reshape(4, 3)) > 0 for plan in plans)
    scouts = Bat(loudness=1e-6, stride=0.0, limit=1, rounds=200)
    assert fitness(problem, found(scouts, 0, 3)) >= fitness(problem, found(silent, 0, 3))
