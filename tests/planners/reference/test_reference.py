from __future__ import annotations

from itertools import pairwise
from unittest.mock import Mock

import numpy as np
import pytest

from indoor_explorers.env import InputError, World, make_policy, scenario
from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.sensing.lidar import scan
from indoor_explorers.evaluation.harness.episodes.runner import fly as fly_tasks
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.planners.reference import plan as planning
from indoor_explorers.planners.reference.annealing import anneal
from indoor_explorers.planners.reference.plan import PlanRequest, SearchBudget, plan, swap_resolved
from tests.planners.flights import fly, maze, rooms

EFFORT = SearchBudget(1, 3000, 10**8)


def task_of(
    free: np.ndarray, starts: tuple[Cell, ...], lidar: float = 3.0, goal: float = 1.0, aim: float = 0.99
) -> PlanRequest:
    truth = np.where(free, 1, 2).astype(np.uint8)
    return PlanRequest(truth.tobytes(), truth.shape, starts, (lidar, "exact", 1, 90.0), False, aim, goal)


def seen_by(request: PlanRequest, tracks: tuple[tuple[Cell, ...], ...]) -> float:
    truth = np.frombuffer(request.truth, np.uint8).reshape(request.shape)
    seen = np.zeros(request.shape, np.bool_)
    for cell in {cell for track in tracks for cell in track}:
        seen |= scan(truth, cell, request.lidar[0]) == 1
    return float(seen.sum() / (truth == 1).sum())


@pytest.mark.parametrize("starts", [((1, 1),), ((1, 1), (1, 2), (3, 1))])
@pytest.mark.parametrize("goal", [0.8, 1.0])
def test_plans_are_ways_that_see_enough(starts: tuple[Cell, ...], goal: float) -> None:
    for free in (maze(5, 6, 1), rooms(2, 4, 1)):
        request = task_of(free, tuple(start for start in starts if free[start]), goal=goal)
        tracks = plan(request, EFFORT)
        assert tuple(track[0] for track in tracks) == request.starts
        for track in tracks:
            assert all(free[cell] for cell in track)
            assert all(abs(a[0] - b[0]) + abs(a[1] - b[1]) == 1 for a, b in pairwise(track))
        assert seen_by(request, tracks) >= goal


def test_the_coverage_aimed_at_is_reached_sooner_than_on_the_way_to_a_higher_one() -> None:
    def steps_to(share: float, request: PlanRequest) -> int:
        (track,) = plan(request, SearchBudget(2, 20_000, 10**8))
        return next(step for step in range(len(track)) if seen_by(request, (track[: step + 1],)) >= share)

    low, high = (task_of(rooms(3, 4, 2), ((1, 1),), aim=aim) for aim in (0.7, 0.99))
    assert steps_to(0.7, low) < steps_to(0.7, high)
    assert steps_to(0.99, low) > steps_to(0.99, high)
    assert plan(task_of(rooms(3, 4, 2), ((1, 1),), goal=0.7), EFFORT) == plan(
        task_of(rooms(3, 4, 2), ((1, 1),), goal=0.7, aim=0.7), EFFORT
    )


def test_a_corridor_is_flown_straight() -> None:
    corridor = np.ones((1, 30), np.bool_)
    assert plan(task_of(corridor, ((0, 0),)), EFFORT) == (tuple((0, col) for col in range(27)),)
    left, right = plan(task_of(corridor, ((0, 14), (0, 15))), EFFORT)
    assert {left[-1], right[-1]} == {(0, 3), (0, 26)}
    assert max(len(left), len(right)) == 12


def test_the_same_task_gives_the_same_plan_and_more_effort_no_worse_ones() -> None:
    request = task_of(rooms(3, 4, 2), ((1, 1),))
    first = plan(request, EFFORT)
    plan.cache_clear()
    assert plan(request, EFFORT) == first
    assert len(plan(request, SearchBudget(4, 20_000, 10**8))[0]) <= len(plan(request, SearchBudget(1, 1, 10**8))[0])


def test_routes_are_searched_once_an_episode_whatever_the_team(monkeypatch: pytest.MonkeyPatch) -> None:
    search = Mock(wraps=anneal)
    monkeypatch.setattr(planning, "anneal", search)
    plan.cache_clear()
    tasks = [Task("thesis-team-4", 0, seed) for seed in range(40)]
    policy = make_policy("reference", restarts=1, changes=1)
    list(fly_tasks(policy, "reference", scenario("thesis-team-4").for_evaluation(), tasks))
    assert search.call_count == len(tasks)


def test_work_bounds_the_search() -> None:
    request = task_of(rooms(3, 4, 2), ((1, 1),))
    assert plan(request, SearchBudget(1, 10**9, 10_000))


def test_with_few_viewpoints_everything_is_seen_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(planning, "TABLE", 600)
    plan.cache_clear()
    request = task_of(maze(6, 7, 3), ((1, 1),), lidar=2.0)
    assert seen_by(request, plan(request, EFFORT)) == 1.0
    plan.cache_clear()


def test_where_not_all_viewpoints_fit_in_memory_the_rest_is_left_to_frontiers(monkeypatch: pytest.MonkeyPatch) -> None:
    free = rooms(3, 5, 4)
    request = task_of(free, ((1, 1),), lidar=2.0)
    plan.cache_clear()
    whole = seen_by(request, plan(request, EFFORT))
    monkeypatch.setattr(planning, "LARGEST_TABLE", 12 * int(free.sum()))
    plan.cache_clear()
    assert 0.3 < seen_by(request, plan(request, EFFORT)) < 0.9 < whole
    assert fly(make_policy("reference"), free, lidar=2.0, spawns=[(1, 1)]).complete
    plan.cache_clear()


def test_uavs_that_would_pass_through_each_other_exchange_their_ways() -> None:
    assert swap_resolved([[1, 2, 3, 4], [4, 3, 2, 1]]) == [[1, 2, 1], [4, 3, 4]]
    assert swap_resolved([[1, 2, 3], [5, 6, 7]]) == [[1, 2, 3], [5, 6, 7]]


@pytest.mark.parametrize("seed", range(5))
def test_exchanged_ways_visit_the_same_cells(seed: int) -> None:
    rng = np.random.default_rng(seed)
    flown = [np.cumsum([start, *rng.choice([-1, 1], 30)]).tolist() for start in (0, 5, 9, 14)]
    found = swap_resolved(flown)
    assert {cell for way in found for cell in way} == {cell for way in flown for cell in way}
    assert all(abs(a - b) == 1 for way in found for a, b in pairwise(way))
    assert [way[0] for way in found] == [0, 5, 9, 14]


def test_it_needs_the_true_map() -> None:
    world = World(scenario("thesis-open"))
    world.begin(0, 0)
    with pytest.raises(InputError, match="true map and all starts"):
        make_policy("reference").pilot(world.briefing(0, 0))
