"""Gymnasium and PettingZoo where sensors or poses err: one action more, and no true pose."""

import gymnasium
import numpy as np

from indoor_explorers.env import TURN, parallel_env

ERRORS = {"noise.misses": 0.05, "drift.rate": 0.05, "lidar.field_of_view": 120.0, "on_collision": "block"}


def made(observation, **settings):
    return gymnasium.make(
        "IndoorExplorers-v0", scenario="thesis-obstacles", observation=observation, settings=ERRORS | settings
    ).unwrapped


def test_there_is_one_action_more():
    env = made("channels")
    assert env.action_space.n == 6
    assert len(env.reset(seed=1)[1]["action_mask"]) == 6
    assert env.action_masks()[TURN]
    assert parallel_env("thesis-team-2", settings=ERRORS).action_space("uav_1").n == 6


def test_planes_show_the_believed_cell_and_the_map_as_it_is_now():
    env = made("channels", **{"drift.rate": 0.5, "drift.closures": 0.0, "lidar.field_of_view": 360.0})
    env.reset(seed=2)
    rng, apart = np.random.default_rng(1), 0
    for _ in range(80):
        planes = env.step(int(rng.integers(5)))[0]
        view, true = env.world.view(0, 0), tuple(env.world.state.cell[0, 0].tolist())
        assert tuple(np.argwhere(planes[3])[0].tolist()) == view.cell
        for value in range(3):
            np.testing.assert_array_equal(planes[value] > 0, view.belief == value)
        apart += view.cell != true
    assert apart > 20
