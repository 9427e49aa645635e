"""The environment of Gymnasium on maps of several levels."""

import gymnasium
import numpy as np
from gymnasium.utils.env_checker import check_env

from indoor_explorers.env.grid.levels import ASCEND
from indoor_explorers.env.interfaces.gymnasium_env import IndoorExplorersEnv
from indoor_explorers.env.scenarios.presets import scenario

SOLO = scenario("small-storeys").with_settings({"team": 1})


def test_gymnasium_accepts_the_environment_and_its_seven_actions():
    env = IndoorExplorersEnv(SOLO)
    assert env.action_space == gymnasium.spaces.Discrete(7)
    check_env(env, skip_render_check=True)


def test_legal_actions_say_where_a_uav_can_rise():
    env = IndoorExplorersEnv(SOLO)
    levels = env.world.briefing(0, 0).levels if env.reset(seed=3) else None
    for _ in range(30):
        mask = env.action_masks()
        assert mask.shape == (7,)
        before = levels.voxel(env.world.view(0, 0).cell)
        _, _, terminated, truncated, info = env.step(ASCEND if mask[ASCEND] else int(np.flatnonzero(mask)[0]))
        if mask[ASCEND]:
            assert levels.voxel(env.world.view(0, 0).cell) == (before[0] + 1, *before[1:])
        if terminated or truncated:
            break
        np.testing.assert_array_equal(info["action_mask"], env.action_masks())
