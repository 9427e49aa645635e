"""Stable-Baselines3 and sb3-contrib: their checks, our batch as their VecEnv, and a policy that learns."""

import sys

import numpy as np
import pytest
import torch
from gymnasium.wrappers import FlattenObservation
from sb3_contrib import MaskablePPO
from sb3_contrib.common.maskable.utils import get_action_masks, is_masking_supported
from stable_baselines3 import PPO
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.vec_env import DummyVecEnv, VecFrameStack, VecMonitor

from indoor_explorers.env import PRESETS, InputError
from indoor_explorers.env.interfaces.gymnasium_env import IndoorExplorersEnv
from indoor_explorers.env.interfaces.stable_baselines import StableBaselinesVecEnv
from indoor_explorers.env.observations import Egocentric, Flat, Masked, Stacked
from indoor_explorers.learners.sessions.process import one_thread
from tests.env.arrays import assert_same

#: A room of 8 x 8 to be known completely within 60 steps, paid by the cell; whoever hits a wall stays where it is.
PLAYROOM = PRESETS["thesis-obstacles"].with_settings(
    {
        "map.height": 8,
        "map.width": 8,
        "map.obstacles": 2,
        "lidar.range": 2.0,
        "on_collision": "block",
        "stuck.rule": "off",
        "denominator": "reachable",
        "goal": 1.0,
        "budget": 60,
        "rewards.step": -0.1,
        "rewards.discovered": 0.2,
        "rewards.collision": 0.0,
        "rewards.out_of_bounds": 0.0,
        "rewards.goal": 5.0,
    }
)
SMALL = Flat(Egocentric(side=9, zones=6))


@pytest.fixture(autouse=True, scope="module")
def _one_thread():
    """The same sums in the same order, whatever else the machine does."""
    with one_thread():
        yield


@pytest.mark.parametrize(
    "observation", ["egocentric-flat", Masked(SMALL), Flat("channels"), Stacked(SMALL, 2)], ids=str
)
def test_the_checker_has_nothing_to_say(observation):
    check_env(IndoorExplorersEnv(observation=observation))


@pytest.mark.parametrize("observation", ["channels", "thesis", "egocentric", Masked("egocentric")], ids=str)
@pytest.mark.filterwarnings("ignore:.*The minimal resolution for an image is 36x36:UserWarning")  # a room is smaller
@pytest.mark.filterwarnings("ignore:.* has an unconventional shape:UserWarning")  # an image (H, W)
@pytest.mark.filterwarnings("ignore:It seems that your observation .* is an image:UserWarning")  # floats, and flattened
def test_the_checker_has_advice_about_images_alone(observation):
    check_env(IndoorExplorersEnv(observation=observation))


@pytest.mark.parametrize("observation", ["channels", "egocentric", Masked(Stacked(SMALL, 2))], ids=str)
@pytest.mark.parametrize("settings", [{"on_collision": "end"}, {"budget": 9, "base.at": "start"}])
def test_the_batch_is_sb3_s_own_vector_of_single_environments(observation, settings):
    kwargs = {"scenario": PLAYROOM, "observation": observation, "settings": settings}
    ours, theirs = StableBaselinesVecEnv(5, **kwargs), DummyVecEnv([lambda: IndoorExplorersEnv(**kwargs)] * 5)
    assert (ours.observation_space, ours.action_space) == (theirs.observation_space, theirs.action_space)
    assert ours.seed(3) == theirs.seed(3)
    assert_same(*(dict(seen) if isinstance(seen, dict) else seen for seen in (ours.reset(), theirs.reset())))
    rng, ended = np.random.default_rng(0), 0
    for _ in range(50):
        masks = get_action_masks(ours)
        assert np.array_equal(masks, get_action_masks(theirs))
        actions = rng.integers(0, 5, 5)
        (seen, pay, over, infos), (wanted, *rest) = ours.step(actions), theirs.step(actions)
        assert_same(
            dict(seen) if isinstance(seen, dict) else seen, dict(wanted) if isinstance(wanted, dict) else wanted
        )
        assert np.array_equal(pay, rest[0])
        assert np.array_equal(over, rest[1])
        for mine, other in zip(infos, rest[2], strict=True):
            assert_same({k: _arrays(v) for k, v in mine.items()}, {k: _arrays(v) for k, v in other.items()})
        for mine, other in zip(ours.reset_infos, theirs.reset_infos, strict=True):
            assert (mine["step"], mine["coverage"]) == (other["step"], other["coverage"])
            for name in ("base_age", "base_coverage"):
                assert mine.get(name) == other.get(name)
                assert (name in mine) == ("base.at" in settings)
        ended += int(over.sum())
    assert ended > 5


def _arrays(value):
    return value if isinstance(value, dict) else np.asarray(value)


def test_the_batch_takes_sb3_s_wrappers_and_refuses_what_it_cannot_do():
    envs = VecFrameStack(VecMonitor(StableBaselinesVecEnv(3, scenario=PLAYROOM, render_mode="rgb_array")), 2)
    assert envs.reset().shape == (3, 14, 8, 8)
    for _ in range(60):
        *_, infos = envs.step(np.full(3, 4))
    assert infos[0]["episode"]["l"] == 60
    assert envs.render().shape[2] == 3
    assert is_masking_supported(envs)
    assert envs.get_attr("num_envs", indices=[0, 2]) == [3, 3]
    assert envs.env_is_wrapped(FlattenObservation) == [False] * 3
    with pytest.raises(InputError, match="share one world"):
        envs.env_method("render")
    with pytest.raises(InputError, match="share one world"):
        envs.set_attr("render_mode", None)
    with pytest.raises(InputError, match="no copy"):
        StableBaselinesVecEnv(2, copy=False)
    envs.close()


def mean_coverage(model, episodes=64, **kwargs):
    """Return the coverage at the end and the return of each episode, on rooms that training never saw."""
    envs = StableBaselinesVecEnv(episodes, scenario=PLAYROOM, observation=SMALL)
    envs.seed(1_000_000)
    seen, paid, coverage, over = envs.reset(), np.zeros(episodes), np.zeros(episodes), np.zeros(episodes, bool)
    torch.manual_seed(0)
    while not over.all():
        seen, pay, done, infos = envs.step(model.predict(seen, deterministic=False)[0])
        paid += np.where(over, 0, pay)
        for b in np.flatnonzero(done & ~over):
            coverage[b] = infos[b]["coverage"]
        over |= done
    return coverage.mean(), paid.mean()


@pytest.mark.slow
def test_ppo_learns_to_explore():
    envs = StableBaselinesVecEnv(16, scenario=PLAYROOM, observation=SMALL)
    model = PPO(
        "MlpPolicy", envs, n_steps=128, batch_size=256, n_epochs=4, learning_rate=1e-3, gamma=0.97, ent_coef=0.01,
        seed=1, device="cpu",
    )  # fmt: skip
    coverage, paid = mean_coverage(model)
    model.learn(40_000)
    learned_coverage, learned_paid = mean_coverage(model)
    assert coverage < 0.7
    assert learned_coverage > 0.88
    assert learned_paid > paid + 5


@pytest.mark.parametrize(
    "make", [StableBaselinesVecEnv, lambda n, **kw: DummyVecEnv([lambda: IndoorExplorersEnv(**kw)] * n)]
)
def test_maskable_ppo_never_makes_an_illegal_move(make):
    """Every move that training makes is seen by a world in which an illegal one would end the episode at once."""
    envs = VecMonitor(make(4, scenario=PLAYROOM, observation=SMALL, settings={"on_collision": "end"}))
    model = MaskablePPO("MlpPolicy", envs, n_steps=128, batch_size=128, n_epochs=1, seed=0, device="cpu")
    ends = []

    def record(local, _):
        ends.extend(info["end"] for info in local["infos"])
        masks = local["action_masks"]
        assert masks[np.arange(4), local["actions"]].all()
        return True

    model.learn(1024, callback=record)
    assert len(ends) == 1024
    assert not {2, 3} & set(ends)  # neither a collision nor out of bounds
    seen = envs.reset()
    for _ in range(50):
        masks = get_action_masks(envs)
        actions, _ = model.predict(seen, action_masks=masks, deterministic=True)
        assert masks[np.arange(4), actions].all()
        seen = envs.step(actions)[0]


@pytest.mark.parametrize("observation", ["egocentric", Masked(Stacked(SMALL, 2))], ids=str)
def test_dict_observations_train_out_of_the_box(observation):
    envs = StableBaselinesVecEnv(4, scenario=PLAYROOM, observation=observation)
    PPO("MultiInputPolicy", envs, n_steps=32, batch_size=64, n_epochs=1, seed=0, device="cpu").learn(128)


def test_a_missing_stable_baselines_names_the_extra(monkeypatch):
    monkeypatch.delitem(sys.modules, "indoor_explorers.env.interfaces.stable_baselines")
    monkeypatch.setitem(sys.modules, "stable_baselines3.common.vec_env", None)
    with pytest.raises(InputError, match=r"indoor-explorers\[sb3\]"):
        import indoor_explorers.env.interfaces.stable_baselines  # noqa: F401
