from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from indoor_explorers.env import Policy, make_policy, scenario
from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.search.bitsets import unpacked
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.planners.frontier.joint import JointPilot
from indoor_explorers.planners.horizon.beam import BeamConfig
from indoor_explorers.planners.horizon.horizon import Horizon, HorizonPilot
from indoor_explorers.planners.horizon.learned_prior import OpenPrior
from indoor_explorers.planners.horizon.tour_planner import TourPlanner
from tests.planners import flights


def mean_time(policy: Policy, task_name: str, metric: str, settings: dict[str, object] | None = None) -> float:
    task = scenario(task_name).for_evaluation().with_settings(settings or {})
    records = fly(policy, "it", task, [Task(task.name, 0, seed) for seed in range(10)])
    return float(np.mean([record.metrics[metric] for record in records]))


@pytest.mark.slow  # golden episodes tell when it flies otherwise
def test_rooms_take_far_fewer_steps_than_to_the_nearest_frontier() -> None:
    nearest = make_policy("frontier-nearest")
    for task in ("thesis-open", "thesis-obstacles", "thesis-team-4"):
        assert mean_time(Horizon(), task, "t99") < 0.8 * mean_time(nearest, task, "t99")


def test_it_aims_at_the_goal_that_it_is_told() -> None:
    everything = mean_time(Horizon(), "thesis-open", "t90")
    assert mean_time(Horizon(), "thesis-open", "t90", {"goal": 0.9}) < everything - 2


@pytest.mark.parametrize("prior", ["source", "belief", "none"])
def test_every_prior_completes_rooms(prior: str) -> None:
    policy = make_policy("horizon", prior=prior)
    (record,) = fly(policy, "it", scenario("thesis-obstacles").for_evaluation(), [Task("thesis-obstacles", 0, 4)])
    assert record.outcome == "complete"


def test_a_tour_is_legal_and_kept_while_it_stands() -> None:
    tours = TourPlanner((10, 12), 3.0, OpenPrior(), BeamConfig(8.0, 0.02, 0.0, 100, 80), goal=1.0, deferred_share=0.0)
    belief = np.zeros((10, 12), np.uint8)
    belief[:3, :3], belief[5, 2:9] = 1, 2
    cell, length = 0, 0
    for step in range(60):
        tours.plan(belief, cell)
        assert step == 0 or tours.length <= length - 1
        length, following = tours.length, tours.following(cell)
        if following is None:
            break
        assert following in tours.optimistic.neighbours[cell]
        cell = following
        belief = np.where(unpacked(tours.optimistic.views[cell], 120).reshape(10, 12) & (belief == 0), 1, belief)
        belief = belief.astype(np.uint8)
    assert not (belief == 0).any()


class WalledLeft:
    """A prior that is sure of obstacles left of column 8."""

    def free_chances(self, belief: Belief) -> NDArray[np.float64]:
        return (np.arange(belief.size) >= 8).astype(np.float64)


def test_a_tour_is_not_drawn_to_what_is_surely_an_obstacle() -> None:
    tours = TourPlanner((1, 30), 1.0, WalledLeft(), BeamConfig(8.0, 0.02, 0.0, 1, 80), goal=1.0, deferred_share=0.0)
    belief = np.zeros((1, 30), np.uint8)
    belief[0, 8:21] = 1
    tours.plan(belief, 13)
    assert tours.following(13) == 14
    assert tours.length == 28 - 13


def test_large_maps_are_flown_by_clusters() -> None:
    rollout = flights.fly(Horizon(room=50), flights.rooms(2, 4, 1))
    assert rollout.complete
    assert isinstance(rollout.pilots[0], JointPilot)
    assert isinstance(flights.fly(Horizon(), flights.rooms(2, 4, 1)).pilots[0], HorizonPilot)
