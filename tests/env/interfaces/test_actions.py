"""What is no action, scenario or setting is refused in one line, wherever it is given."""

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, Action, InputError, World, env, parallel_env
from indoor_explorers.env.interfaces import IndoorExplorersEnv, IndoorExplorersVectorEnv

TASK = "thesis-team-2"
WRONG: tuple[tuple[object, str], ...] = (
    (0.5, "an int from 0 to 4, got the float 0.5"),
    (np.round(1.2), "an int from 0 to 4, got the float 1.0"),
    (1j, "an int from 0 to 4, got the complex 1j"),
    (True, "an int from 0 to 4, got the bool True"),
    ("1", "an int from 0 to 4, got the str '1'"),
    ({}, "an int from 0 to 4, got the dict {}"),
    (object(), "an int from 0 to 4, got the object <object object at"),
    ([1, [2]], "an int from 0 to 4, got the list"),
    (None, "an action from 0 to 4, got None"),
    (2**70, "an action from 0 to 4, got 1180591620717411303424"),
)


def begun():
    made = World(PRESETS[TASK])
    made.reset([1])
    return made


#: What is stepped, and how it is given an action.
STEPS = {
    "world": (begun, lambda made, action: made.step([[action, action]])),
    "single": (IndoorExplorersEnv, lambda made, action: made.step(action)),
    "vector": (lambda: IndoorExplorersVectorEnv(2), lambda made, action: made.step([action, action])),
    "together": (lambda: parallel_env(TASK), lambda made, action: made.step({"uav_0": 4, "uav_1": action})),
    "in turn": (lambda: env(TASK), lambda made, action: made.step(action)),
}


@pytest.mark.parametrize("kind", STEPS)
def test_what_is_no_action_is_refused_in_one_line(kind):
    make, step = STEPS[kind]
    made = make()
    if kind != "world":
        made.reset(seed=1)
    for action, message in WRONG:
        with pytest.raises(InputError) as refused:
            step(made, action)
        assert message in str(refused.value)
        assert str(refused.value).isprintable()
    for right in (4, np.int8(4), np.uint64(4), np.array(4), Action.STAY):
        step(made, right)


@pytest.mark.parametrize("given", [None, 4, [4, 4]])
def test_a_team_s_actions_are_a_dict(given):
    made = parallel_env(TASK)
    made.reset(seed=1)
    with pytest.raises(InputError, match="expected a dict with one action for each of"):
        made.step(given)


@pytest.mark.parametrize("make", [IndoorExplorersEnv, lambda **k: IndoorExplorersVectorEnv(2, **k), parallel_env, env])
def test_what_is_no_scenario_or_settings_is_refused_in_one_line(make):
    with pytest.raises(InputError, match=r"expected a scenario, the name of a preset or a \.toml file, got 5"):
        make(scenario=5)
    with pytest.raises(InputError, match=r"expected settings by name such as .*, got \[1\]"):
        make(settings=[1])
