from __future__ import annotations

from itertools import product
from math import exp

import numpy as np
import pytest

from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.planners.swarm import particles
from indoor_explorers.planners.swarm.assignment import (
    Assignment,
    AssignmentProblem,
    Plan,
    by_greed,
    by_hungarian,
    by_minpos,
    discounted,
    fitness,
    reachable_or_nearest,
)
from indoor_explorers.planners.swarm.particles import code_of, decode, keys_of, optimise


def some_task(seed: int, uavs: int = 4, candidates: int = 7) -> AssignmentProblem:
    rng = np.random.default_rng(seed)
    steps = rng.integers(1, 30, (uavs, candidates)).astype(np.float64)
    steps[rng.random(steps.shape) < 0.2] = UNREACHABLE
    steps[:, 0] = rng.integers(1, 30, uavs)
    views = rng.random((candidates, 40)) < 0.3
    views[:, 0] = True
    both = (views[:, None] & views[None]).sum(axis=2).astype(np.float64)
    return AssignmentProblem(
        steps=steps,
        hops=rng.integers(1, 20, (candidates, candidates)).astype(np.float64),
        gains=np.diag(both).copy(),
        shared=both / np.diag(both)[:, None],
        hysteresis=rng.choice([1.0, 1.2], (uavs, candidates)),
        power=0.5,
        rate=0.1,
        trust=0.6,
        lidar_range=5.0,
    )


def seeds_of(problem: AssignmentProblem) -> list[Assignment]:
    return [
        by_greed(problem),
        by_hungarian(problem),
        by_minpos(problem),
        reachable_or_nearest(problem, np.full(len(problem.steps), -1)),
    ]


def seeded(problem: AssignmentProblem, length: int) -> list[Plan]:
    """The initial plans: the seeds, continued by the best next goals."""
    code = code_of(problem, length)
    plans = [np.empty((len(problem.steps), length), np.int64) for _ in range(4)]
    for plan, goals in zip(plans, seeds_of(problem), strict=True):
        decode(keys_of(goals, code, length), code, plan)
    return plans


def reference(problem: AssignmentProblem, plan: Plan) -> float:
    """The fitness, visit by visit."""
    visits = []
    for uav, goals in enumerate(plan.tolist()):
        time = 0.0
        for turn, goal in enumerate(goals):
            if goal < 0:
                break
            time += problem.hops[goals[turn - 1], goal] if turn else problem.steps[uav, goal]
            visits.append((time, turn, uav, goal))
    visits.sort(key=lambda visit: visit[0])
    total = 0.0
    for place, (time, turn, uav, goal) in enumerate(visits):
        left = np.prod([1 - problem.shared[goal, other] for *_, other in visits[:place]])
        worth = (problem.gains[goal] * left) ** problem.power * exp(-problem.rate * time) * problem.trust**turn
        total += worth * (1.0 if turn else problem.hysteresis[uav, goal])
    return float(total)


@pytest.mark.parametrize("seed", range(8))
def test_fitness_is_the_formula(seed: int) -> None:
    problem, rng = some_task(seed), np.random.default_rng(seed)
    plan = rng.integers(0, 7, (4, 3))
    plan[0, 2] = plan[1, 1] = -1
    plan[:, 0] = by_minpos(problem)
    assert fitness(problem, plan) == pytest.approx(reference(problem, plan))


def test_the_same_view_counts_once_and_early_ones_more() -> None:
    problem = some_task(0)._replace(steps=np.array([[1.0, 5.0], [2.0, 9.0]]), hysteresis=np.ones((2, 2)))
    problem = problem._replace(gains=np.array([4.0, 4.0]), shared=np.eye(2), hops=np.full((2, 2), 3.0))
    assert fitness(problem, np.array([[0], [0]])) == pytest.approx(2 * exp(-0.1))
    assert fitness(problem, np.array([[0], [1]])) == pytest.approx(2 * exp(-0.1) + 2 * exp(-0.9))


@pytest.mark.parametrize("length", [1, 3])
@pytest.mark.parametrize("seed", range(30))
def test_the_swarm_never_loses_to_its_seeds(seed: int, length: int) -> None:
    problem = some_task(seed, uavs=1 + seed % 8, candidates=1 + seed % 11)
    best = optimise(problem, length, seeds_of(problem), 5, 4, np.random.default_rng(seed))
    for plan in seeded(problem, length):
        assert fitness(problem, best) >= fitness(problem, plan)
    assert (problem.steps[np.arange(len(best)), best[:, 0]] < UNREACHABLE).all()
    for goals in best.tolist():
        visited = [goal for goal in goals if goal >= 0]
        assert len(set(visited)) == len(visited) == min(length, len(problem.gains))


@pytest.mark.parametrize("seed", range(6))
def test_the_swarm_finds_the_best_of_few(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    problem = some_task(seed, uavs=2, candidates=4)
    monkeypatch.setattr(particles, "STAGNATION", 40)
    best = optimise(problem, 2, seeds_of(problem), 60, 80, np.random.default_rng(seed))
    rows = [
        [(a, b) for a in range(4) for b in range(4) if a != b and problem.steps[i, a] < UNREACHABLE] for i in range(2)
    ]
    assert fitness(problem, best) == pytest.approx(max(fitness(problem, np.array(plan)) for plan in product(*rows)))


def test_searching_finds_better_plans_than_its_seeds() -> None:
    better = 0
    for seed in range(20):
        problem = some_task(seed, uavs=4, candidates=20)
        best = fitness(problem, optimise(problem, 3, seeds_of(problem), 20, 30, np.random.default_rng(seed)))
        better += best > 1.001 * max(fitness(problem, plan) for plan in seeded(problem, 3))
    assert better >= 15


def test_greed_takes_the_best_pair_first() -> None:
    problem = some_task(2)
    goals, worth = by_greed(problem), discounted(problem)
    first = np.unravel_index(worth.argmax(), worth.shape)
    assert goals[first[0]] == first[1]


def test_minpos_ranks_by_who_is_nearer() -> None:
    problem = some_task(0, uavs=2, candidates=2)._replace(steps=np.array([[1.0, 9.0], [2.0, 8.0]]))
    assert by_minpos(problem).tolist() == [0, 1]


@pytest.mark.parametrize("seed", range(5))
def test_keys_decode_to_what_they_encode(seed: int) -> None:
    problem = some_task(seed)
    code, plan = code_of(problem, 3), np.empty((4, 3), np.int64)
    decode(keys_of(by_minpos(problem), code, 3), code, plan)
    assert plan[:, 0].tolist() == by_minpos(problem).tolist()
    for first, second, _ in plan.tolist():
        assert second == next(goal for goal in code.followers[first].tolist() if goal != first)
