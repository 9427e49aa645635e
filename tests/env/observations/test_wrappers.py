"""Encoders made of encoders: dicts, vectors, memories."""

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box

from indoor_explorers.env import PRESETS, World, parallel_env
from indoor_explorers.env.interfaces.gymnasium_env import IndoorExplorersEnv
from indoor_explorers.env.interfaces.vector import IndoorExplorersVectorEnv
from indoor_explorers.env.observations import Egocentric, Encoder, Flat, Masked, Parts, Stacked, make_encoder
from tests.env.arrays import assert_same

CALM = PRESETS["thesis-obstacles"].with_settings({"on_collision": "block", "stuck.rule": "off", "budget": 7})


def begun():
    world = World(CALM)
    world.reset([3])
    return world


def seen_by(observation, world):
    return make_encoder(observation, world.briefing(0, 0)).observation(world.view(0, 0))


def test_parts_are_named_and_dicts_among_them_joined():
    world = begun()
    seen = seen_by(Parts({"image": "thesis", "rest": Egocentric(), "flat": Flat("self")}), world)
    assert list(seen) == ["coarse", "crop", "flat", "image", "status"]
    assert_same(seen["image"], seen_by("thesis", world))
    assert_same(seen["crop"], seen_by("egocentric", world)["crop"])


def test_a_mask_is_the_legal_moves_beside_the_observation_or_its_parts():
    world = begun()
    for observation, names in (("thesis", {"observation"}), ("egocentric", {"coarse", "crop", "status"})):
        seen = seen_by(Masked(observation), world)
        assert seen.keys() == names | {"action_mask"}
        assert seen["action_mask"].dtype == np.int8
        assert np.array_equal(seen["action_mask"], world.view(0, 0).legal)
    assert seen_by(Masked("thesis", "observations"), world).keys() == {"observations", "action_mask"}


@pytest.mark.parametrize("observation", ["channels", "thesis", "egocentric", Masked("channels")], ids=str)
def test_flat_is_gymnasium_s_order_with_bytes_as_shares(observation):
    world = begun()
    inner = make_encoder(observation, world.briefing(0, 0))
    seen = inner.observation(world.view(0, 0))
    shares = {
        k: v / 255 if v.dtype == np.uint8 else v for k, v in (seen if isinstance(seen, dict) else {"": seen}).items()
    }
    wanted = np.concatenate([shares[name].ravel() for name in getattr(inner.space, "spaces", [""])])
    flat = seen_by(Flat(observation), world)
    assert flat.dtype == np.float32
    assert np.allclose(flat, wanted)
    assert flat.shape == gymnasium.spaces.flatten_space(inner.space).shape


@pytest.mark.parametrize(
    ("stacked", "plain", "shape"),
    [
        (Stacked("free+self", 4), "free+self", (8, 16, 16)),
        (Stacked("thesis", 4), "thesis", (4, 16, 16)),
        (Stacked(Flat("thesis"), 4), "thesis", (1024,)),
        (Flat(Stacked("thesis", 4)), "thesis", (1024,)),
    ],
)
def test_a_stack_is_the_last_observations_oldest_first(stacked, plain, shape):
    env, plain = IndoorExplorersEnv(CALM, observation=stacked), IndoorExplorersEnv(CALM, observation=plain)
    assert env.observation_space.shape == shape
    for episode in range(3):
        seen, last = env.reset(seed=episode)[0], plain.reset(seed=episode)[0]
        frames = [last] * 4
        for action in (0, 1, 2, 3, 0, 0):
            assert_same(seen.ravel(), np.concatenate([frame.ravel() for frame in frames]))
            seen = env.step(action)[0]
            frames = [*frames[1:], plain.step(action)[0]]


def test_a_step_encoded_twice_counts_once():
    world = begun()
    encoder = make_encoder(Stacked("self", 3), world.briefing(0, 0))
    first = encoder.observation(world.view(0, 0))
    assert_same(encoder.observation(world.view(0, 0)), first)
    legal = int(np.flatnonzero(world.view(0, 0).legal)[0])
    world.step(np.array([[legal]]))
    second = encoder.observation(world.view(0, 0))
    assert_same(encoder.observation(world.view(0, 0)), second)
    assert np.array_equal(second[:2], first[:2])
    assert not np.array_equal(second[2], first[2])


def test_every_part_of_a_dict_is_stacked():
    world = begun()
    seen, stacked = seen_by("egocentric", world), seen_by(Stacked("egocentric", 2), world)
    for name, part in seen.items():
        assert_same(stacked[name], np.concatenate([part, part]))


class Clock(Encoder):
    """Counts the views that it was shown in this episode: a memory that nobody told the faces about."""

    def __init__(self, briefing):
        self.space = Box(0, 1000, (1,), np.int64)
        self.reset()

    def reset(self):
        self.shown = 0

    def encode(self, view, out):
        self.shown += 1
        out[:] = self.shown


@pytest.mark.parametrize("mode", ["NEXT_STEP", "SAME_STEP"])
def test_each_episode_of_a_batch_has_a_memory_of_its_own(mode):
    envs = IndoorExplorersVectorEnv(3, CALM, observation=Clock, autoreset_mode=mode)
    assert envs.reset(seed=0)[0].tolist() == [[1], [1], [1]]
    envs.step(np.full(3, 4))
    masked = {"reset_mask": np.array([False, True, False])}
    assert envs.reset(options=masked)[0].tolist() == [[2], [1], [2]]
    for _ in range(6):
        seen, *_, infos = envs.step(np.full(3, 4))
    if mode == "SAME_STEP":
        assert infos["final_obs"].tolist() == [np.array([8]), None, np.array([8])]
    wanted = [[8], [7], [8]] if mode == "NEXT_STEP" else [[1], [7], [1]]
    assert seen.tolist() == wanted


class Peek(Encoder):
    """One encoder for a whole batch, without a kernel for it."""

    stateless = True

    def __init__(self, briefing):
        self.space = Box(0, 2, briefing.shape, np.uint8)

    def encode(self, view, out):
        assert not any(array.flags.writeable for array in (view.belief, view.legal, view.visited))
        out[:] = view.belief


def test_an_encoder_can_neither_change_the_world_nor_must_know_batches():
    envs, team = IndoorExplorersVectorEnv(3, observation=Peek), parallel_env(observation=Peek)
    assert np.array_equal(envs.reset(seed=0)[0], envs.world.state.belief[:, 0])
    assert len(team.reset(seed=0)[0]) == 4


def test_a_team_s_memories_are_its_members():
    team = parallel_env("thesis-team-2", observation=Clock, settings={"on_collision": "block"})
    for _ in range(2):
        assert all(seen == 1 for seen in team.reset(seed=0)[0].values())
        assert all(seen == 2 for seen in team.step({"uav_0": 4, "uav_1": 4})[0].values())
