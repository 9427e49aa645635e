"""RLlib: a team trains on the PettingZoo interface with shared parameters, in this process."""

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, parallel_env
from indoor_explorers.env.observations import Egocentric, Flat
from tests.documents import SITE, python_of

pytestmark = pytest.mark.xdist_group("ray")
#: A room of 8 x 8 for two; whoever hits a wall stays where it is.
PLAYROOM = PRESETS["thesis-team-2"].with_settings(
    {
        "map.height": 8,
        "map.width": 8,
        "map.obstacles": 2,
        "on_collision": "block",
        "stuck.rule": "off",
        "budget": 40,
        "rewards.collision": -1.0,
        "rewards.out_of_bounds": -1.0,
        "rewards.goal": 5.0,
    }
)


def team(scenario=PLAYROOM):
    from ray.rllib.env.wrappers.pettingzoo_env import ParallelPettingZooEnv  # takes seconds, and each process collects

    return ParallelPettingZooEnv(parallel_env(scenario, observation=Flat(Egocentric(side=7, zones=4))))


@pytest.mark.slow
@pytest.mark.usefixtures("connected", "one_thread")
@pytest.mark.filterwarnings("ignore:.*Overriding environment rllib")  # it registers its own with every algorithm
def test_a_team_trains_with_shared_parameters_as_the_guide_shows():
    (snippet,) = (text for text in python_of(SITE / "pages" / "guides" / "learner.md") if "from ray" in text)
    shown = {}
    exec(compile(snippet, "learner.md", "exec"), shown)
    algorithm = shown["algorithm"]
    try:
        before = algorithm.get_module("shared").get_state()
        result = algorithm.train()
        after = algorithm.get_module("shared").get_state()
    finally:
        algorithm.stop()
    flown = result["env_runners"]
    assert flown["num_env_steps_sampled_lifetime"] >= 2000
    assert set(flown["agent_episode_returns_mean"]) == {"uav_0", "uav_1"}
    assert np.isfinite([flown["episode_return_mean"], result["learners"]["shared"]["total_loss"]]).all()
    assert any(not np.array_equal(before[name], after[name]) for name in after)


@pytest.mark.parametrize("seed", range(8))
def test_rllib_sees_every_episode_end_for_all(seed):
    """Also where some of the team end early and the others by the budget, which its wrapper only sees a step later."""
    envs, rng = team(PLAYROOM.with_settings({"on_collision": "end"})), np.random.default_rng(seed)
    observations, _ = envs.reset(seed=seed)
    for _ in range(42):
        assert all(envs.observation_space[agent].contains(seen) for agent, seen in observations.items())
        moves = {agent: int(rng.choice([4, 4, 4, 0, 1])) for agent in envs.par_env.agents}
        observations, _, terminated, truncated, _ = envs.step(moves)
        if terminated["__all__"] or truncated["__all__"]:
            break
    assert not envs.par_env.agents
