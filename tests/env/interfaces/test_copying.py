"""Copies of environments, made in the middle of an episode: the same future, and independent ones."""

import copy
import pickle

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence

from indoor_explorers.env import env, parallel_env
from indoor_explorers.env.interfaces import IndoorExplorersEnv, IndoorExplorersVectorEnv
from indoor_explorers.env.observations import Egocentric, Masked, Parts, Stacked
from tests.env.interfaces.switches import SWITCHES

SAFE = {"on_collision": "block", "stuck.rule": "off", "budget": 25}
MANY = Masked(Parts({"near": Stacked(Egocentric(base=True), 2), "map": "channels"}))
ID = "indoor_explorers.env:IndoorExplorers-v0"


def alone(made, rng):
    done = False
    while True:
        result = made.reset() if done else made.step(int(rng.integers(5)))
        done = len(result) > 2 and (result[2] or result[3])
        yield result


def in_turn(made, rng):
    while True:
        if not made.agents:
            made.reset()
        *_, terminated, truncated, _ = told = made.last()
        made.step(None if terminated or truncated else int(rng.integers(5)))
        yield made.agent_selection, told


def together(made, rng):
    while True:
        yield made.step({agent: int(rng.integers(5)) for agent in made.agents}) if made.agents else made.reset()


def many(made, rng):
    while True:
        yield made.step(rng.integers(0, 5, 3))


#: Ways to make an environment, and to fly it.
KINDS = {
    "gymnasium": (IndoorExplorersEnv, alone),
    "gymnasium.make": (lambda **kwargs: gymnasium.make(ID, **kwargs), alone),
    "parallel": (parallel_env, together),
    "turns": (env, in_turn),
    "vector": (lambda **kwargs: IndoorExplorersVectorEnv(3, **kwargs), many),
    "vector, same step": (
        lambda **kwargs: IndoorExplorersVectorEnv(3, autoreset_mode="SAME_STEP", copy=False, **kwargs),
        many,
    ),
}


def after(made, flight, seed, steps):
    """What a flight of so many steps gives."""
    results = flight(made, np.random.default_rng(seed))
    return [copy.deepcopy(next(results)) for _ in range(steps)]


@pytest.mark.parametrize("way", [copy.deepcopy, lambda made: pickle.loads(pickle.dumps(made))], ids=["copy", "pickle"])
@pytest.mark.parametrize("observation", ["channels", MANY], ids=["planes", "dict"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_copy_flies_on_bit_for_bit_and_alone(kind, observation, way):
    make, flight = KINDS[kind]
    made = make(observation=observation, settings=SAFE)
    made.reset(seed=3)
    after(made, flight, 1, 15)
    twin, third = way(made), way(made)
    expected = after(made, flight, 2, 20)
    for each in (twin, third):
        assert data_equivalence(after(each, flight, 2, 20), expected, exact=True)


@pytest.mark.parametrize("settings", SWITCHES.values(), ids=SWITCHES)
def test_a_copy_flies_on_in_harder_tasks(settings):
    team = parallel_env(settings=settings | {"on_collision": "block"}, observation=MANY)
    team.reset(seed=4)
    after(team, together, 1, 10)
    twin = pickle.loads(pickle.dumps(team))
    assert data_equivalence(after(twin, together, 2, 30), after(team, together, 2, 30), exact=True)


def test_a_copy_has_a_picture_and_a_window_of_its_own():
    made, shown = (IndoorExplorersEnv(render_mode=mode) for mode in ("rgb_array", "human"))
    for each in (made, shown):
        each.reset(seed=1)
        each.step(0)
    twin, other = copy.deepcopy(made), copy.deepcopy(shown)
    before = made.render()
    assert np.array_equal(twin.render(), before)
    for action in (1, 2, 3):
        twin.step(action)
    assert not np.array_equal(twin.render(), before)
    assert np.array_equal(made.render(), before)
    other.step(4)
    other.close()
    shown.step(4)
    shown.close()
