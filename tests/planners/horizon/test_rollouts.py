from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import make_policy, scenario
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.maps.generators.thesis import ThesisMaps
from indoor_explorers.env.search.bitsets import around
from indoor_explorers.env.sensing.lidar import lidar_model, scan
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.planners.horizon.rollout_choice import RolloutSelection
from indoor_explorers.planners.horizon.rollouts import FOLLOWED, LONGEST, RolloutSetup, steps_to_shares
from indoor_explorers.planners.horizon.room_prior import RoomPrior
from indoor_explorers.planners.toolbox.information.optimistic_views import OptimisticViews

ALL = np.array([1.0])


def corridor(known: int, length: int = 10) -> np.ndarray:
    belief = np.full((1, length), UNKNOWN, np.uint8)
    belief[0, :known] = FREE
    return belief


def setup_of(belief: np.ndarray, lidar_range: float) -> tuple[RolloutSetup, OptimisticViews]:
    optimistic = OptimisticViews(belief.shape, lidar_range)
    optimistic.update(belief)
    chances = (belief == UNKNOWN).ravel().astype(np.float64)
    return RolloutSetup(belief, chances, optimistic.views, optimistic.neighbours, around(belief.shape, 2)), optimistic


@pytest.mark.slow
def test_the_quick_policy_sees_all_of_a_corridor_without_detours() -> None:
    setup, _ = setup_of(corridor(3), 2.0)
    rooms = np.full((1, 10), FREE, np.uint8)
    steps = steps_to_shares(0, setup, [[]], rooms, np.array([0.5, 1.0]), lidar_model(2.0))
    assert steps.tolist() == [[[2, 7]]]


def test_a_detour_at_the_start_of_a_tour_is_flown() -> None:
    setup, _ = setup_of(corridor(3), 2.0)
    rooms = np.full((1, 10), FREE, np.uint8)
    steps = steps_to_shares(1, setup, [[2, 3], [0, 1]], rooms, ALL, lidar_model(2.0))
    assert steps.ravel().tolist() == [6, 8]
    assert FOLLOWED < LONGEST


def test_only_what_can_be_reached_is_wanted_and_a_blocked_tour_is_left() -> None:
    setup, _ = setup_of(corridor(3), 2.0)
    rooms = np.full((1, 10), FREE, np.uint8)
    rooms[0, 6] = OCCUPIED
    steps = steps_to_shares(0, setup, [list(range(1, 10))], rooms, ALL, lidar_model(2.0))
    assert steps.ravel().tolist() == [3]


def test_flights_end_in_every_sampled_room() -> None:
    source = ThesisMaps()
    truth = source.floorplan(0, 5).truth
    start = int(np.flatnonzero(truth.ravel() == FREE)[0])
    belief = scan(truth, divmod(start, 16), 3.0)
    prior = RoomPrior(source, np.random.default_rng(1), 64, 10)
    prior.free_chances(belief)
    rooms = prior.rooms(belief)
    assert len(rooms) > 0
    known = belief.ravel() != UNKNOWN
    assert (rooms[:, known] == belief.ravel()[known]).all()
    setup, _ = setup_of(belief, 3.0)
    steps = steps_to_shares(start, setup, [[]], rooms, np.array([0.5, 0.9]), lidar_model(3.0))[0]
    assert (steps[:, 0] < steps[:, 1]).all()
    assert (steps[:, 1] < LONGEST).all()


def test_rollouts_leave_a_tour_for_a_better_one_only() -> None:
    source = ThesisMaps(height=2, width=20, obstacles=0)
    belief = np.full((2, 20), UNKNOWN, np.uint8)
    belief[:, :6] = FREE
    prior = RoomPrior(source, np.random.default_rng(0), 8, 1)
    setup, optimistic = setup_of(belief, 3.0)
    selection = RolloutSelection(prior, (2, 20), 3.0, 1.0, 8)
    ahead, back = list(range(4, 12)), [2, 1, 0]
    assert selection.best(belief, 3, optimistic, setup.chances, [ahead, back]) == 0
    assert selection.best(belief, 3, optimistic, setup.chances, [back, ahead]) == 1


@pytest.mark.slow
def test_flights_with_rollouts_complete_and_repeat() -> None:
    task = scenario("thesis-obstacles").for_evaluation()
    tasks = [Task(task.name, 0, seed) for seed in (1, 7)]
    policy = make_policy("horizon", rollouts=24)
    once, again = (
        {r.task: (str(r.outcome), r.steps) for r in fly(policy, "it", task, order)} for order in (tasks, tasks[::-1])
    )
    assert once == again
    assert all(outcome == "complete" for outcome, _ in once.values())
    assert once != {r.task: (str(r.outcome), r.steps) for r in fly(make_policy("horizon"), "it", task, tasks)}
