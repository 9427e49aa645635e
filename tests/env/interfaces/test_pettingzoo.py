"""The PettingZoo interface: the ecosystem's own checks, and the same episodes as the bare world's."""

import subprocess
import sys
import warnings
from types import SimpleNamespace

import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import data_equivalence

from indoor_explorers.env import PRESETS, InputError, World, env, parallel_env
from indoor_explorers.env.observations import Egocentric, Masked, Stacked, make_encoder
from indoor_explorers.env.rendering.window import load_pygame
from indoor_explorers.env.simulation.state import End
from tests.env.arrays import assert_same
from tests.env.interfaces.switches import SWITCHES

SAFE = {"on_collision": "block", "stuck.rule": "off"}


@pytest.fixture(autouse=True)
def _installed():
    pytest.importorskip("pettingzoo")
    with warnings.catch_warnings():  # its tests import one of its own games, which warns of how it is imported
        warnings.filterwarnings("ignore", "The old environment creation API", DeprecationWarning)
        warnings.filterwarnings("ignore", "pkg_resources is deprecated", UserWarning)
        import pettingzoo.test  # noqa: F401


@pytest.mark.parametrize(
    "observation", ["channels", "thesis", "egocentric", Masked("channels"), Stacked("thesis")], ids=str
)
@pytest.mark.parametrize("settings", [{}, SAFE | {"budget": 40}])
def test_pettingzoo_s_parallel_checks(observation, settings):
    from pettingzoo.test import parallel_api_test, parallel_seed_test

    parallel_api_test(parallel_env(observation=observation, settings=settings), num_cycles=200)
    parallel_seed_test(lambda: parallel_env(observation=observation, settings=settings), num_cycles=50)


@pytest.mark.parametrize("settings", SWITCHES.values(), ids=SWITCHES)
def test_pettingzoo_s_parallel_checks_of_harder_tasks(settings):
    from pettingzoo.test import parallel_api_test

    parallel_api_test(parallel_env(scenario="thesis-team-4", settings=settings), num_cycles=200)


def test_pettingzoo_s_parallel_checks_of_several_levels():
    from pettingzoo.test import parallel_api_test

    parallel_api_test(parallel_env(scenario="small-storeys"), num_cycles=50)


def test_a_uav_that_stops_has_terminated():
    env = parallel_env(scenario="thesis-team-2", settings={"failures.stops": ((1, 2),), "on_collision": "block"})
    env.reset(seed=1)
    env.step(dict.fromkeys(env.agents, 4))
    _, rewards, terminated, truncated, _ = env.step(dict.fromkeys(env.agents, 4))
    assert terminated == {"uav_0": False, "uav_1": True}
    assert not any(truncated.values())
    assert env.agents == ["uav_0"]
    assert rewards["uav_1"] == -0.5


@pytest.mark.parametrize("settings", [{}, SAFE | {"budget": 40}])
@pytest.mark.parametrize("observation", ["channels", "egocentric", Masked("egocentric-flat")], ids=str)
@pytest.mark.filterwarnings("ignore:Observation is not a NumPy array:UserWarning")  # PettingZoo warns of every dict
@pytest.mark.filterwarnings("ignore:Observation space for each agent probably should be:UserWarning")
def test_pettingzoo_s_turn_by_turn_checks(settings, observation):
    from pettingzoo.test import api_test, seed_test

    api_test(env(settings=settings, observation=observation), num_cycles=200)
    seed_test(lambda: env(settings=settings), num_cycles=50)


def test_the_budget_is_pettingzoo_s_max_cycles():
    from pettingzoo.test import max_cycles_test

    def budgeted(make):
        return lambda max_cycles: make(settings=SAFE | {"budget": max_cycles})

    max_cycles_test(SimpleNamespace(parallel_env=budgeted(parallel_env), env=budgeted(env)))


def test_the_global_state_is_the_true_map_and_what_everybody_knows():
    from pettingzoo.test.state_test import state_test

    team = parallel_env("thesis-team-2", settings=SAFE | {"radio.model": "none"})
    with pytest.raises(ResetNeeded):
        team.state()
    state_test(env("thesis-team-2", settings=SAFE), team)
    team.reset(seed=3)
    team.step(dict.fromkeys(team.agents, 2))
    state, world = team.state(), team.world.state
    np.testing.assert_array_equal(state[0] == 1, world.truth[0] == 1)
    np.testing.assert_array_equal(state[1], state[2] | state[3])
    np.testing.assert_array_equal(state[2:4] == 1, world.belief[0] > 0)
    assert [tuple(np.argwhere(plane)[0]) for plane in state[4:]] == [tuple(cell) for cell in world.cell[0]]
    assert state[4:].sum() == 2
    together = env("thesis-team-2", settings=SAFE)
    together.reset(seed=3)
    assert together.state_space.contains(together.state())


def test_a_uav_that_has_ended_is_not_in_the_global_state():
    team = parallel_env("thesis-team-2", settings={"on_collision": "end"})
    team.reset(seed=0)
    while len(team.agents) == 2:
        team.step(dict.fromkeys(team.agents, 1))
    assert team.state()[4:].sum() == len(team.agents)


def test_pettingzoo_s_render_test():
    from pettingzoo.test.render_test import render_test

    def blocked(render_mode):
        return env(render_mode=render_mode, settings=SAFE)

    render_test(blocked)
    assert env().metadata["render_modes"] == ["human", "rgb_array"]


def test_a_team_s_window_shows_every_step_by_itself():
    team = parallel_env(render_mode="human")
    team.reset(seed=0)
    assert load_pygame().display.get_init()
    team.step(dict.fromkeys(team.agents, 4))
    assert team.render() is None
    team.close()
    assert not load_pygame().display.get_init()


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("settings", [{}, SAFE | {"budget": 30, "base.at": "start"}, {"goal_of": "team", "goal": 0.5}])
@pytest.mark.parametrize("observation", ["channels", Stacked(Egocentric(base=True), 2)], ids=str)
def test_an_episode_is_the_bare_world_s(seed, settings, observation):
    scenario = PRESETS["thesis-team-4"].with_settings(settings)
    team = parallel_env(settings=settings, observation=observation)
    world, rng = World(scenario), np.random.default_rng(seed)
    world.reset([seed])
    encoders = [make_encoder(observation, world.briefing(0, n)) for n in range(4)]
    observations, infos = team.reset(seed=seed)
    while True:
        assert observations.keys() == infos.keys()
        for agent, info in infos.items():
            n = int(agent.removeprefix("uav_"))
            view = world.view(0, n)
            assert_same(observations[agent], encoders[n].observation(view))
            assert info["action_mask"].dtype == np.int8
            assert np.array_equal(info["action_mask"], view.legal)
            assert (info["coverage"], info["step"]) == (world.coverage[0, n], view.step)
            if scenario.base.exists:
                age = -1 if view.base_age is None else view.base_age
                assert (info["base_age"], info["base_coverage"]) == (age, world.base_coverage[0])
        assert team.agents == [f"uav_{n}" for n in np.flatnonzero(world.flying[0])]
        if not team.agents:
            break
        actions = rng.integers(0, 5, 4)
        flew = list(team.agents)
        world.step(actions[None])
        observations, rewards, terminations, truncations, infos = team.step(
            {agent: int(actions[int(agent.removeprefix("uav_"))]) for agent in flew}
        )
        assert list(observations) == flew
        for agent in flew:
            n = int(agent.removeprefix("uav_"))
            end = world.state.end[0, n]
            assert rewards[agent] == world.state.reward[0, n]
            assert terminations[agent] is bool(End.FLYING < end < End.BUDGET)
            assert truncations[agent] is bool(end == End.BUDGET)
            assert infos[agent]["end"] == end


@pytest.mark.parametrize("observation", ["channels", Masked(Stacked("egocentric", 2))], ids=str)
def test_turn_by_turn_is_the_same_episode(observation):
    """With actions that each agent draws from a stream of its own."""

    def draws():
        return {f"uav_{n}": np.random.default_rng(n) for n in range(4)}

    def parallel():
        team, rng, told = parallel_env(observation=observation), draws(), {agent: [] for agent in draws()}
        seen, infos = team.reset(seed=6)
        for agent in team.agents:
            told[agent].append((seen[agent], 0, False, False, infos[agent]))
        while team.agents:
            results = team.step({a: int(rng[a].integers(5)) for a in team.agents})
            for agent in results[0]:
                told[agent].append(tuple(result[agent] for result in results))
        return told

    def in_turn():
        team, rng, told = env(observation=observation), draws(), {agent: [] for agent in draws()}
        team.reset(seed=6)
        for agent in team.agent_iter():
            told[agent].append(team.last())
            over = told[agent][-1][2] or told[agent][-1][3]
            team.step(None if over else int(rng[agent].integers(5)))
        return told

    one, other = parallel(), in_turn()
    assert one.keys() == other.keys()
    for agent in one:
        assert len(one[agent]) == len(other[agent]) > 1
        assert data_equivalence(one[agent], other[agent], exact=True)


def test_resets_without_a_seed_draw_new_episodes_that_the_first_seed_decides():
    def episodes():
        team = parallel_env()
        team.reset(seed=1)
        return [(team.reset(), team.world.seeds[0])[1] for _ in range(3)]

    assert episodes() == episodes()
    assert len(set(episodes())) == 3


@pytest.mark.parametrize("make", [parallel_env, env])
def test_a_first_seed_is_added_to_every_seed_given_or_drawn(make):
    team = make("thesis-team-2", first_seed=2**40)
    team.reset(seed=3)
    assert team.unwrapped.world.seeds == [2**40 + 3]
    team.reset()
    assert team.unwrapped.world.seeds[0] >= 2**40


def test_what_cannot_be_used_is_refused():
    with pytest.raises(InputError, match="did you mean 'thesis-team-2'"):
        parallel_env("thesis-team2")
    with pytest.raises(InputError, match="did you mean 'channels'"):
        env(observation="chanels")
    with pytest.raises(ResetNeeded):
        parallel_env().step({})
    team = parallel_env()
    team.reset(seed=0)
    with pytest.raises(InputError, match="one action for each"):
        team.step({"uav_0": 4})
    with pytest.raises(InputError, match="from 0 to 4"):
        team.step(dict.fromkeys(team.agents, 9))


def test_a_team_of_one_is_a_team():
    team = parallel_env("thesis-obstacles")
    team.reset(seed=0)
    assert team.agents == ["uav_0"]


def test_a_missing_pettingzoo_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "pettingzoo", None)
    with pytest.raises(InputError, match=r"indoor-explorers\[marl\]"):
        parallel_env()


def test_the_world_does_not_import_pettingzoo():
    code = "import sys, indoor_explorers.env; sys.exit('pettingzoo' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
