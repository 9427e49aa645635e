"""The Gymnasium interfaces: the ecosystem's own checks, and the same episodes as the bare world's."""

import sys
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env, data_equivalence
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers.vector import RecordEpisodeStatistics

from indoor_explorers.env import PRESETS, InputError, World
from indoor_explorers.env.interfaces.gymnasium_env import IndoorExplorersEnv
from indoor_explorers.env.interfaces.vector import IndoorExplorersVectorEnv
from indoor_explorers.env.observations import (
    Egocentric,
    Encoder,
    Flat,
    Heading,
    Masked,
    Occupancy,
    Parts,
    Stacked,
    make_encoder,
)
from indoor_explorers.env.rendering import Trails, paint, scene_of
from indoor_explorers.env.rendering.window import Window, load_pygame
from indoor_explorers.env.simulation.state import End
from tests.env.arrays import assert_same
from tests.env.interfaces.switches import SWITCHES

ID = "indoor_explorers.env:IndoorExplorers-v0"
ERRORS = {"noise.misses": 0.05, "drift.rate": 0.05, "lidar.field_of_view": 120.0, "budget": 30}

OBSERVATIONS = (
    "channels",
    "thesis",
    "free+self",
    "egocentric",
    "egocentric-flat",
    Masked("egocentric"),
    Stacked("channels", 2),
    Flat(Stacked("egocentric", 3)),
)


def make_vec(num_envs, **kwargs):
    return gymnasium.make_vec(ID, num_envs, "vector_entry_point", **kwargs)


@pytest.mark.parametrize(
    ("observation", "render_mode"), [(each, None) for each in OBSERVATIONS] + [("channels", "rgb_array")], ids=str
)
def test_the_checker_has_nothing_to_say(observation, render_mode):
    _check(gymnasium.make(ID, observation=observation, render_mode=render_mode))


@pytest.mark.parametrize("settings", SWITCHES.values(), ids=SWITCHES)
def test_the_checker_has_nothing_to_say_of_harder_tasks(settings):
    _check(gymnasium.make(ID, scenario="thesis-obstacles", settings=settings))


def _check(env):
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        check_env(env.unwrapped)
    assert [str(warning.message) for warning in said] == []


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("settings", [{}, {"on_collision": "block", "budget": 30, "base.at": "start"}])
@pytest.mark.parametrize("observation", ["channels", Stacked(Egocentric(base=True), 2)], ids=str)
def test_an_episode_is_the_bare_world_s(seed, settings, observation):
    scenario = PRESETS["thesis-obstacles"].with_settings(settings)
    env = gymnasium.make(ID, settings=settings, observation=observation)
    world, rng = World(scenario), np.random.default_rng(seed)
    world.reset([seed])
    encoder = make_encoder(observation, world.briefing(0, 0))
    observation, info = env.reset(seed=seed)
    done = False
    while True:
        view = world.view(0, 0)
        assert_same(observation, encoder.observation(view))
        assert info["action_mask"].dtype == np.int8
        assert np.array_equal(info["action_mask"], view.legal)
        assert np.array_equal(env.unwrapped.action_masks(), view.legal)
        assert (info["coverage"], info["step"]) == (world.coverage[0, 0], view.step)
        if scenario.base.exists:
            assert (info["base_age"], info["base_coverage"]) == (view.base_age, world.base_coverage[0])
        else:
            assert not {"base_age", "base_coverage"} & info.keys()
        if done:
            break
        action = int(rng.integers(5))
        world.step(np.array([[action]]))
        observation, reward, terminated, truncated, info = env.step(action)
        end = End(int(world.state.end[0, 0]))
        assert reward == world.state.reward[0, 0]
        assert terminated == (end in {End.GOAL, End.COLLISION, End.OUT_OF_BOUNDS, End.STUCK})
        assert truncated == (end == End.BUDGET)
        assert info["end"] == end
        done = terminated or truncated


def test_ends_of_each_kind_are_told_apart():
    def last(env, actions):
        env.reset(seed=1)
        for action in actions:
            result = env.step(action)
        return result

    *_, terminated, truncated, info = last(gymnasium.make(ID, scenario="thesis-open"), [2] * 16)
    assert (terminated, truncated, info["end"]) == (True, False, End.OUT_OF_BOUNDS)
    *_, terminated, truncated, info = last(gymnasium.make(ID), [4] * 20)
    assert (terminated, truncated, info["end"]) == (True, False, End.STUCK)
    *_, terminated, truncated, info = last(gymnasium.make(ID, settings={"goal": 0.01}), [4])
    assert (terminated, truncated, info["end"]) == (True, False, End.GOAL)
    *_, terminated, truncated, info = last(gymnasium.make(ID, settings={"budget": 3}), [4] * 3)
    assert (terminated, truncated, info["end"]) == (False, True, End.BUDGET)


def test_resets_without_a_seed_draw_new_episodes_that_the_first_seed_decides():
    def episodes(seed):
        env = IndoorExplorersEnv()
        env.reset(seed=seed)
        seeds = []
        for _ in range(3):
            env.reset()
            seeds += env.world.seeds
        return seeds

    assert episodes(1) == episodes(1) != episodes(2)
    assert len(set(episodes(1))) == 3


def test_a_first_seed_is_added_to_every_seed_given_or_drawn():
    first, ends = 2**40, {"settings": {"budget": 2}}
    single, several = IndoorExplorersEnv(**ends, first_seed=first), make_vec(3, **ends, first_seed=first)
    alike, other = IndoorExplorersEnv(**ends), IndoorExplorersEnv(**ends, first_seed=first)
    assert_same(single.reset(seed=7)[0], alike.reset(seed=first + 7)[0])
    several.reset(seed=5)
    assert several.unwrapped.world.seeds == [first + 5, first + 6, first + 7]
    for _ in range(7):  # two steps and a reset
        several.step(np.full(3, 4))
    single.reset()
    single.reset()
    assert several.unwrapped.world.seeds[2] == single.world.seeds[0] >= first
    several.reset(seed=[None, 1, None])
    assert several.unwrapped.world.seeds[1] == first + 1
    other.reset()
    assert first <= other.world.seeds[0] < first + 2**31


def test_observations_stay_as_they_were_given():
    for env, action in ((IndoorExplorersEnv(), 4), (IndoorExplorersVectorEnv(2), np.array([4, 4]))):
        first, info = env.reset(seed=0)
        kept, mask = first.copy(), info["action_mask"].copy()
        second = env.step(action)[0]
        env.reset(seed=5)
        assert np.array_equal(first, kept)
        assert np.array_equal(info["action_mask"], mask)
        assert not np.shares_memory(first, second)


def test_without_copies_the_next_call_overwrites_the_observation():
    for env, action in (
        (IndoorExplorersEnv(copy=False), 4),
        (IndoorExplorersVectorEnv(2, copy=False), np.array([4, 4])),
    ):
        fresh = type(env)(env.num_envs) if isinstance(env, IndoorExplorersVectorEnv) else type(env)()
        first = env.reset(seed=0)[0]
        assert_same(first, fresh.reset(seed=0)[0])
        assert env.step(action)[0] is first
        assert_same(first, fresh.step(action)[0])


@pytest.mark.parametrize("observation", OBSERVATIONS, ids=str)
def test_a_seed_decides_all_that_follows(observation):
    def flight(env):
        env.action_space.seed(5)
        yield env.reset(seed=11)
        assert env.unwrapped.np_random_seed == 11
        for _ in range(25):
            result = env.step(env.action_space.sample())
            yield result if not (result[2] or result[3]) else env.reset()

    flights = (flight(gymnasium.make(ID, observation=observation)) for _ in range(2))
    assert all(data_equivalence(one, other, exact=True) for one, other in zip(*flights, strict=True))


def test_what_cannot_be_used_is_refused():
    with pytest.raises(InputError, match="parallel_env"):
        IndoorExplorersEnv("thesis-team-4")
    with pytest.raises(InputError, match="parallel_env"):
        make_vec(2, scenario="thesis-team-2")
    with pytest.raises(InputError, match="did you mean 'thesis-open'"):
        IndoorExplorersEnv("thesis-opne")
    with pytest.raises(InputError, match="did you mean 'budget'"):
        IndoorExplorersEnv(settings={"budgte": 3})
    with pytest.raises(InputError, match="did you mean 'rgb_array'"):
        IndoorExplorersEnv(render_mode="rgb_aray")
    with pytest.raises(InputError, match="index"):
        IndoorExplorersEnv(index=1)
    with pytest.raises(InputError, match="num_envs"):
        make_vec(0)
    with pytest.raises(InputError, match="did you mean 'SAME_STEP'"):
        make_vec(2, autoreset_mode="SAMESTEP")
    with pytest.raises(InputError, match="one seed for each"):
        make_vec(2).reset(seed=[1])
    with pytest.raises(InputError, match="reset_mask"):
        make_vec(2).reset(options={"reset_mask": [1, 0]})
    with pytest.raises(InputError, match="from 0 to 4"):
        make_stepped(IndoorExplorersEnv(), 5)
    with pytest.raises(InputError, match="shape"):
        make_stepped(make_vec(2), np.zeros(3, np.int64))


def make_stepped(env, action):
    env.reset(seed=0)
    return env.step(action)


@pytest.mark.parametrize("make", [IndoorExplorersEnv, IndoorExplorersVectorEnv])
def test_a_step_before_the_first_reset_is_refused(make):
    with pytest.raises(gymnasium.error.ResetNeeded):
        make().step(np.array([4]) if make is IndoorExplorersVectorEnv else 4)


def test_a_scenario_may_be_a_file_or_an_object(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('preset = "thesis-open"\nbudget = 7\n', encoding="utf-8")
    assert IndoorExplorersEnv(str(path)).world.scenario.budget == 7
    assert IndoorExplorersEnv(PRESETS["office"], settings={"team": 1}).observation_space.shape[0] == 7


def test_pictures_have_one_size_and_a_trail_since_the_reset():
    env = IndoorExplorersEnv(render_mode="rgb_array", settings={"on_collision": "block"})
    env.reset(seed=3)
    first = env.render()
    for action in (0, 0, 0, 3, 3, 3, 2, 1) * 3:
        env.step(action)
        picture = env.render()
        assert (picture.shape, picture.dtype) == (first.shape, np.uint8)
    trails = Trails(env.world.state.truth.shape[1:])
    trails.restart(env.world.state.cell[0])
    assert not np.array_equal(picture, paint(scene_of(env.world, 0, trails)))
    assert not np.array_equal(picture, first)
    env.reset(seed=3)
    assert np.array_equal(env.render(), first)
    assert IndoorExplorersEnv().render() is None


@pytest.mark.parametrize("render_mode", ["rgb_array", "human"])
def test_pictures_change_nothing_in_an_episode(render_mode):
    seen, unseen = (gymnasium.make(ID, render_mode=mode) for mode in (render_mode, None))
    seen.unwrapped._renderer._window = None  # no need to wait for a window that nobody looks at
    rng = np.random.default_rng(0)
    assert data_equivalence(seen.reset(seed=5), unseen.reset(seed=5), exact=True)
    for action in rng.integers(0, 5, 8).tolist():
        assert data_equivalence(seen.step(action), unseen.step(action), exact=True)


def test_a_window_shows_every_step_by_itself_and_closes_with_the_environment(monkeypatch):
    shown = []
    show = Window.show
    monkeypatch.setattr(Window, "show", lambda self, picture: (shown.append(picture), show(self, picture)))
    env = gymnasium.make(ID, render_mode="human", settings={"on_collision": "block"})
    env.unwrapped._renderer._window._fps = 1000
    env.reset(seed=1)
    env.step(4)
    env.step(4)
    assert env.render() is None
    assert len(shown) == 4
    pygame = load_pygame()
    assert pygame.display.get_init()
    env.close()
    assert not pygame.display.get_init()
    env.close()


def test_an_environment_with_a_window_needs_pygame(monkeypatch):
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(InputError, match=r"indoor-explorers\[render\]"):
        IndoorExplorersEnv(render_mode="human")
    with pytest.raises(InputError, match="unknown render mode 'human'; known: rgb_array"):
        make_vec(2, render_mode="human")


def sync(num_envs, autoreset_mode=AutoresetMode.NEXT_STEP, **kwargs):
    return SyncVectorEnv([lambda: IndoorExplorersEnv(**kwargs)] * num_envs, autoreset_mode=autoreset_mode)


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
@pytest.mark.parametrize("seed", [0, [9, 3, 9, 1, 2, 5, 8]])
@pytest.mark.parametrize(
    "kwargs",
    [
        {},
        {"observation": "thesis", "settings": {"on_collision": "block", "budget": 9}},
        {"observation": Masked(Egocentric(base=True)), "settings": {"base.at": "start"}},
        {"observation": Stacked("egocentric-flat", 3)},
        {"observation": Masked(Parts({"p": Occupancy(), "heading": Heading(), "map": "channels"})), "settings": ERRORS},
    ],
)
def test_the_vector_face_is_single_environments_side_by_side(mode, seed, kwargs):
    """Autoresets, spaces and infos included, as Gymnasium's own vectoriser has them."""
    ours, theirs = make_vec(7, autoreset_mode=mode, **kwargs), sync(7, mode, **kwargs)
    assert ours.metadata["autoreset_mode"] is mode
    assert (ours.observation_space, ours.action_space) == (theirs.observation_space, theirs.action_space)
    assert data_equivalence(ours.reset(seed=seed), theirs.reset(seed=seed), exact=True)
    rng, ended = np.random.default_rng(4), 0
    for _ in range(60):
        masks = [env.unwrapped.action_masks() for env in theirs.envs]
        assert np.array_equal(ours.unwrapped.action_masks(), masks)
        actions = rng.integers(0, ours.unwrapped.single_action_space.n, 7)
        result, wanted = ours.step(actions), theirs.step(actions)
        finals = [infos.pop("final_obs", np.array([])) for infos in (result[4], wanted[4])]
        assert data_equivalence(*(tuple(each) for each in finals), exact=True)
        assert data_equivalence(result, wanted, exact=True)
        ended += int((result[2] | result[3]).sum())
    assert ended > 7
    assert data_equivalence(ours.reset(), theirs.reset(), exact=True)


def test_the_declared_autoreset_mode_is_next_step():
    for mode in AutoresetMode:
        assert make_vec(2, autoreset_mode=mode).autoreset_mode is sync(2, mode).autoreset_mode is mode
    assert make_vec(2).metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    assert make_vec(2, autoreset_mode="SAME_STEP").metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    assert make_vec(2, autoreset_mode="Disabled").metadata["autoreset_mode"] is AutoresetMode.DISABLED


def test_without_autoreset_an_ended_episode_waits_for_its_reset():
    envs = make_vec(2, settings={"budget": 2}, autoreset_mode=AutoresetMode.DISABLED)
    envs.reset(seed=0)
    envs.step(np.array([4, 4]))
    assert envs.step(np.array([4, 4]))[3].tolist() == [True, True]
    with pytest.raises(gymnasium.error.ResetNeeded):
        envs.step(np.array([4, 4]))
    envs.reset(options={"reset_mask": np.array([True, True])})
    envs.step(np.array([4, 4]))


def test_a_masked_reset_starts_the_chosen_episodes_only():
    ours, theirs = make_vec(3), sync(3)
    mask = np.array([True, False, True])
    for envs in (ours, theirs):
        envs.reset(seed=0)
        envs.step(np.array([4, 4, 4]))
    (seen, info), (wanted, _) = (e.reset(seed=[7, None, 8], options={"reset_mask": mask}) for e in (ours, theirs))
    assert np.array_equal(seen, wanted)
    assert info["_step"].tolist() == mask.tolist()
    assert info["step"].tolist() == [0, 0, 0]


def test_vectors_with_an_encoder_that_knows_no_batches_and_with_wrappers():
    class Known(Encoder):
        def __init__(self, briefing):
            self.space = gymnasium.spaces.Box(0, 2, briefing.shape, np.uint8)

        def encode(self, view, out):
            out[:] = view.belief

    envs = RecordEpisodeStatistics(make_vec(3, observation=Known, render_mode="rgb_array"))
    observation, _ = envs.reset(seed=0)
    assert np.array_equal(observation, envs.unwrapped.world.state.belief[:, 0])
    assert [picture.shape for picture in envs.render()] == [(654, 608, 3)] * 3
    for _ in range(20):
        *_, infos = envs.step(np.array([4, 4, 4]))
    assert infos["episode"]["l"].tolist() == [20, 20, 20]
    envs.close()


def test_the_vector_face_pictures_each_episode_as_the_single_environment_does():
    ours, theirs = (make(3, render_mode="rgb_array") for make in (make_vec, sync))
    with pytest.raises(gymnasium.error.ResetNeeded):
        ours.render()
    rng = np.random.default_rng(8)
    for envs in (ours, theirs):
        envs.reset(seed=2)
    for _ in range(25):
        actions = rng.integers(0, 5, 3)
        ours.step(actions)
        theirs.step(actions)
        for our, their in zip(ours.render(), theirs.render(), strict=True):
            assert np.array_equal(our, their)
