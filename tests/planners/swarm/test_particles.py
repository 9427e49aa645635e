from __future__ import annotations

from itertools import product
from math import exp

import numpy as np
import pytest

from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.planners.swarm.assignment import (
    Assignment,
    Plan,
    Task,
    by_greed,
    by_hungarian,
    by_minpos,
    discounted,
    fitness,
    reachable_or_nearest,
)
from indoor_explorers.planners.swarm.particles import Swarm, code_of, decode, keys_of, optimise, seeded


def some_task(seed: int, uavs: int = 4, candidates: int = 7) -> Task:
    rng = np.random.default_rng(seed)
    steps = rng.integers(1, 30, (uavs, candidates)).astype(np.float64)
    steps[rng.random(steps.shape) < 0.2] = UNREACHABLE
    steps[:, 0] = rng.integers(1, 30, uavs)
    views = rng.random((candidates, 40)) < 0.3
    views[:, 0] = True
    both = (views[:, None] & views[None]).sum(axis=2).astype(np.float64)
    return Task(
        steps=steps,
        hops=rng.integers(1, 20, (candidates, candidates)).astype(np.float64),
        gains=np.diag(both).copy(),
        shared=both / np.diag(both)[:, None],
        favour=rng.choice([1.0, 1.2], (uavs, candidates)),
        power=0.5,
        rate=0.1,
        trust=0.6,
        lidar_range=5.0,
    )


def seeds_of(task: Task) -> list[Assignment]:
    return [
        by_greed(task),
        by_hungarian(task),
        by_minpos(task),
        reachable_or_nearest(task, np.full(len(task.steps), -1)),
    ]


def reference(task: Task, plan: Plan) -> float:
    """The fitness, visit by visit."""
    visits = []
    for uav, goals in enumerate(plan.tolist()):
        time = 0.0
        for turn, goal in enumerate(goals):
            if goal < 0:
                break
            time += task.hops[goals[turn - 1], goal] if turn else task.steps[uav, goal]
            visits.append((time, turn, uav, goal))
    visits.sort(key=lambda visit: visit[0])
    total = 0.0
    for place, (time, turn, uav, goal) in enumerate(visits):
        left = np.prod([1 - task.shared[goal, other] for *_, other in visits[:place]])
        worth = (task.gains[goal] * left) ** task.power * exp(-task.rate * time) * task.trust**turn
        total += worth * (1.0 if turn else task.favour[uav, goal])
    return float(total)


@pytest.mark.parametrize("seed", range(8))
def test_fitness_is_the_formula(seed: int) -> None:
    task, rng = some_task(seed), np.random.default_rng(seed)
    plan = rng.integers(0, 7, (4, 3))
    plan[0, 2] = plan[1, 1] = -1
    plan[:, 0] = by_minpos(task)
    assert fitness(task, plan) == pytest.approx(reference(task, plan))


def test_the_same_view_counts_once_and_early_ones_more() -> None:
    task = some_task(0)._replace(steps=np.array([[1.0, 5.0], [2.0, 9.0]]), favour=np.ones((2, 2)))
    task = task._replace(gains=np.array([4.0, 4.0]), shared=np.eye(2), hops=np.full((2, 2), 3.0))
    assert fitness(task, np.array([[0], [0]])) == pytest.approx(2 * exp(-0.1))
    assert fitness(task, np.array([[0], [1]])) == pytest.approx(2 * exp(-0.1) + 2 * exp(-0.9))


@pytest.mark.parametrize("length", [1, 3])
@pytest.mark.parametrize("seed", range(30))
def test_the_swarm_never_loses_to_its_seeds(seed: int, length: int) -> None:
    task = some_task(seed, uavs=1 + seed % 8, candidates=1 + seed % 11)
    best = optimise(task, length, Swarm(particles=5, rounds=4), seeds_of(task), np.random.default_rng(seed))
    for plan in seeded(task, length, seeds_of(task)):
        assert fitness(task, best) >= fitness(task, plan)
    assert (task.steps[np.arange(len(best)), best[:, 0]] < UNREACHABLE).all()
    for goals in best.tolist():
        visited = [goal for goal in goals if goal >= 0]
        assert len(set(visited)) == len(visited) == min(length, len(task.gains))


@pytest.mark.parametrize("seed", range(6))
def test_the_swarm_finds_the_best_of_few(seed: int) -> None:
    task = some_task(seed, uavs=2, candidates=4)
    swarm = Swarm(particles=60, rounds=80, stagnation=40)
    best = optimise(task, 2, swarm, seeds_of(task), np.random.default_rng(seed))
    rows = [[(a, b) for a in range(4) for b in range(4) if a != b and task.steps[i, a] < UNREACHABLE] for i in range(2)]
    assert fitness(task, best) == pytest.approx(max(fitness(task, np.array(plan)) for plan in product(*rows)))


def test_searching_finds_better_plans_than_its_seeds() -> None:
    better = 0
    for seed in range(20):
        task = some_task(seed, uavs=4, candidates=20)
        best = fitness(task, optimise(task, 3, Swarm(), seeds_of(task), np.random.default_rng(seed)))
        better += best > 1.001 * max(fitness(task, plan) for plan in seeded(task, 3, seeds_of(task)))
    assert better >= 15


def test_the_same_generator_gives_the_same_plan() -> None:
    task = some_task(1)
    found = [optimise(task, 3, Swarm(), seeds_of(task), np.random.default_rng(3)).tolist() for _ in range(2)]
    assert found[0] == found[1]


def test_greed_takes_the_best_pair_first() -> None:
    task = some_task(2)
    goals, worth = by_greed(task), discounted(task)
    first = np.unravel_index(worth.argmax(), worth.shape)
    assert goals[first[0]] == first[1]


@pytest.mark.parametrize("seed", range(10))
def test_hungarian_is_the_cheapest(seed: int) -> None:
    task = some_task(seed, uavs=3, candidates=5)
    steps = np.where(task.steps < UNREACHABLE, task.steps, 1e9)
    cheapest = min(sum(steps[i, c] for i, c in enumerate(g)) for g in product(range(5), repeat=3) if len(set(g)) == 3)
    if cheapest < 1e9:
        assert steps[np.arange(3), by_hungarian(task)].sum() == cheapest


def test_more_uavs_than_candidates_share() -> None:
    task = some_task(0, uavs=5, candidates=2)._replace(steps=np.ones((5, 2)))
    counts = np.bincount(by_hungarian(task), minlength=2)
    assert sorted(counts.tolist()) == [2, 3]


def test_minpos_ranks_by_who_is_nearer() -> None:
    task = some_task(0, uavs=2, candidates=2)._replace(steps=np.array([[1.0, 9.0], [2.0, 8.0]]))
    assert by_minpos(task).tolist() == [0, 1]


@pytest.mark.parametrize("seed", range(5))
def test_keys_decode_to_what_they_encode(seed: int) -> None:
    task = some_task(seed)
    code, plan = code_of(task, 3), np.empty((4, 3), np.int64)
    decode(keys_of(by_minpos(task), code, 3), code, plan)
    assert plan[:, 0].tolist() == by_minpos(task).tolist()
    for first, second, _ in plan.tolist():
        assert second == next(goal for goal in code.followers[first].tolist() if goal != first)
