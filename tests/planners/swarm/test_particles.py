from __future__ import annotations

from itertools import product
from math import hypot, pi

import numpy as np
import pytest

from indoor_explorers.env.grid import UNREACHABLE
from indoor_explorers.planners.gains import bit_count
from indoor_explorers.planners.swarm.assignment import (
    Assignment,
    Task,
    by_hungarian,
    by_minpos,
    fitness,
    reachable_or_nearest,
)
from indoor_explorers.planners.swarm.particles import Swarm, keys_of, optimise


def some_task(seed: int, uavs: int = 4, candidates: int = 7) -> Task:
    rng = np.random.default_rng(seed)
    steps = rng.integers(1, 30, (uavs, candidates)).astype(np.float64)
    steps[rng.random(steps.shape) < 0.2] = UNREACHABLE
    steps[:, 0] = rng.integers(1, 30, uavs)
    return Task(
        steps=steps,
        points=rng.integers(0, 20, (candidates, 2)).astype(np.float64),
        sights=rng.integers(0, 2**63, (candidates, 3), dtype=np.uint64),
        lidar_range=5.0,
        weights=np.array([1.0, 1.0, 0.5, 0.3]),
    )


def seeds_of(task: Task) -> list[Assignment]:
    return [by_hungarian(task), by_minpos(task), reachable_or_nearest(task, np.full(len(task.steps), -1))]


@pytest.mark.parametrize("seed", range(5))
def test_fitness_is_the_formula(seed: int) -> None:
    task = some_task(seed)
    goals = np.random.default_rng(seed).integers(0, 7, 4)
    views = [{bit for bit in range(192) if int(task.sights[g, bit // 64]) >> bit % 64 & 1} for g in goals]
    steps = [task.steps[i, g] for i, g in enumerate(goals)]
    apart = [hypot(*(task.points[a] - task.points[b])) for i, a in enumerate(goals) for b in goals[:i]]
    mean = sum(steps) / 4
    expected = (
        len(set().union(*views)) / (pi * 25 * 4)
        - mean / 5
        - 0.5 * sum(max(0.0, 1 - d / 5) for d in apart)
        - 0.3 * (max(steps) - mean) / 5
    )
    assert fitness(task, goals) == pytest.approx(expected)


@pytest.mark.parametrize("seed", range(30))
def test_the_swarm_never_loses_to_its_seeds(seed: int) -> None:
    task = some_task(seed, uavs=1 + seed % 8, candidates=1 + seed % 11)
    best = optimise(task, Swarm(particles=5, rounds=4), seeds_of(task), np.random.default_rng(seed))
    for goals in seeds_of(task):
        assert fitness(task, best) >= fitness(task, goals)
    assert (task.steps[np.arange(len(best)), best] < UNREACHABLE).all()


@pytest.mark.parametrize("seed", range(6))
def test_the_swarm_finds_the_best_of_few(seed: int) -> None:
    task = some_task(seed, uavs=2, candidates=5)
    best = optimise(task, Swarm(particles=40, rounds=60, stagnation=30), seeds_of(task), np.random.default_rng(seed))
    reachable = [g for g in product(range(5), repeat=2) if all(task.steps[i, c] < UNREACHABLE for i, c in enumerate(g))]
    assert fitness(task, best) == pytest.approx(max(fitness(task, np.array(goals)) for goals in reachable))


def test_the_same_generator_gives_the_same_assignment() -> None:
    task = some_task(1)
    found = [optimise(task, Swarm(), seeds_of(task), np.random.default_rng(3)).tolist() for _ in range(2)]
    assert found[0] == found[1]


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


def test_keys_decode_to_what_they_encode() -> None:
    choices, counts = np.array([[2, 0, 1], [1, 2, 0]]), np.array([3, 2])
    assert keys_of(np.array([1, 1]), choices, counts).tolist() == pytest.approx([2.5 / 3, 0.25])


def test_bits_are_counted() -> None:
    for word in (0, 1, 2**63, 2**64 - 1, 0xF0F0123456789ABC):
        assert int(bit_count(np.uint64(word))) == word.bit_count()
