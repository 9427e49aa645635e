from __future__ import annotations

import pickle

import numpy as np
import pytest

from indoor_explorers.env import InputError, Policy, make_policy
from indoor_explorers.env.grid.arrays import Mask
from tests.policies import PLANNERS

from .flights import fly, maze, rooms

RADIOS = [("none", 0.0), ("square", 3.0), ("disc", 5.0), ("unlimited", 0.0)]


@pytest.fixture(params=PLANNERS)
def policy(request: pytest.FixtureRequest) -> Policy:
    return make_policy(request.param)


@pytest.mark.parametrize("lidar", [1.0, 3.0, 5.5])
def test_alone_it_completes_every_map_without_dithering(policy: Policy, free: Mask, lidar: float) -> None:
    flight = fly(policy, free, lidar=lidar, budget=1000)
    assert flight.complete
    assert flight.longest_dither <= 6


@pytest.mark.parametrize("radio", RADIOS, ids=lambda radio: radio[0])
@pytest.mark.parametrize("team", [2, 5, 16])
def test_teams_complete_every_map_without_dithering(
    policy: Policy, free: Mask, team: int, radio: tuple[str, float]
) -> None:
    flight = fly(policy, free, team=team, radio=radio, budget=3000)
    assert flight.complete
    assert flight.longest_dither <= 6


@pytest.mark.parametrize("shape", [(1, 1), (1, 12), (12, 1), (2, 2)])
def test_the_smallest_maps(policy: Policy, shape: tuple[int, int]) -> None:
    assert fly(policy, np.ones(shape, np.bool_), lidar=1.0, budget=60).complete


def test_it_beats_the_random_walk(policy: Policy, free: Mask) -> None:
    walk = fly(make_policy("random"), free, budget=4000)
    assert fly(policy, free).steps < walk.steps


def test_it_flies_the_same_again(policy: Policy) -> None:
    flights = [
        fly(copy, rooms(2, 4, 3), team=3, radio=("disc", 6.0), seed=5)
        for copy in (policy, pickle.loads(pickle.dumps(policy)))
    ]
    assert flights[0].actions == flights[1].actions


def test_with_nothing_left_to_explore_it_stays(policy: Policy) -> None:
    free = np.zeros((3, 9), np.bool_)
    free[1, :4] = free[1, 5:] = True
    flight = fly(policy, free, team=2, spawns=[(1, 0), (1, 8)], budget=40, goal_of="agent")
    assert [row[0] for row in flight.actions[10:]] == [4] * 30


def test_head_on_in_a_corridor_resolves(policy: Policy) -> None:
    free = np.zeros((7, 30), np.bool_)
    free[1:6, :5] = free[1:6, 25:] = free[3] = True
    for seed in range(5):
        flight = fly(policy, free, team=2, seed=seed, spawns=[(3, 12), (3, 17)], goal_of="agent", lidar=1.0)
        assert (flight.world.state.end == 1).all()
        assert flight.steps < 800


def test_teams_without_radio_pass_each_other_in_a_maze(policy: Policy) -> None:
    flight = fly(policy, maze(4, 5, 2), team=3, goal_of="agent", budget=4000)
    assert (flight.world.state.end == 1).all()


@pytest.mark.parametrize("radio", RADIOS, ids=lambda radio: radio[0])
def test_a_lost_teammate_stalls_nobody(policy: Policy, radio: tuple[str, float]) -> None:
    flight = fly(policy, maze(5, 5, 4), team=3, radio=radio, ends={0: 4, 2: 9}, budget=1500)
    assert flight.complete
    assert flight.longest_dither <= 6


def test_the_random_walk_takes_every_legal_move() -> None:
    flight = fly(make_policy("random"), np.ones((5, 5), np.bool_), budget=200, lidar=1.0)
    assert {action for (action,) in flight.actions} <= {0, 1, 2, 3}
    assert fly(make_policy("random"), np.ones((1, 1), np.bool_), budget=3).complete


@pytest.mark.parametrize(
    ("name", "parameters"),
    [("rrt-frontier", {"global_samples": 0}), ("rrt-frontier", {"edge": float("nan")}), ("pso", {"candidates": -1})],
)
def test_bad_parameters_are_refused(name: str, parameters: dict[str, float]) -> None:
    with pytest.raises(InputError, match=f"expected {next(iter(parameters))} of at least"):
        make_policy(name, **parameters)
