"""The thesis's settings: Tables 4.1 and 4.2, and what each switch does to the task."""

import pytest

from indoor_explorers.env import PRESETS
from indoor_explorers.learners.thesis.config import MENDED, TrainingConfig

#: Table 4.2, scenario by scenario: step, collision, out of bounds, stuck, new cell, bonus.
TABLE = {
    1: (-0.5, -400.0, -400.0, -400.0, 1.0, 400.0),
    2: (-1.0, -100_000.0, -100_000.0, -10_000.0, 10.0, 10_000.0),
    3: (-10.0, -1000.0, -1000.0, -1000.0, 10.0, 1000.0),
}


@pytest.mark.parametrize("number", TABLE)
def test_the_reward_scenarios_are_those_of_the_table(number):
    pay = TrainingConfig(reward_scenario=number).task(PRESETS["thesis-open"]).rewards
    assert (pay.step, pay.collision, pay.out_of_bounds, pay.stuck, pay.discovered, pay.goal) == TABLE[number]


def test_the_hyperparameters_are_those_of_the_table():
    config = TrainingConfig()
    assert (config.batch, config.learn_every, config.target_every) == (32, 10, 10_000)
    assert (config.learning_rate, config.gamma, config.memory) == (1e-4, 0.99, 100_000)
    assert (config.epsilon_first, config.epsilon_last, config.epsilon_decay) == (1.0, 0.01, 0.99999)
    assert (config.environments, config.episodes) == (1, 10_000)


def test_exploration_falls_by_a_factor_a_decision_down_to_its_last_value():
    config = TrainingConfig()
    assert config.epsilon(0) == 1.0
    assert config.epsilon(1000) == pytest.approx(0.99999**1000)
    assert config.epsilon(460_514) > 0.01 == config.epsilon(460_518)


@pytest.mark.parametrize("number", TABLE)
@pytest.mark.parametrize("paid", [True, False])
def test_received_cells_are_paid_like_discovered_ones_or_not_at_all(number, paid):
    task = TrainingConfig(reward_scenario=number, received_rewarded=paid).task(PRESETS["thesis-team-4"])
    assert task.rewards.received == (TABLE[number][4] if paid else 0.0)


def test_a_terminal_reward_is_that_of_the_goal_and_the_penalty_of_the_other_ends():
    scenario = PRESETS["thesis-rewards-3-stuck-2"]
    rewards = TrainingConfig(terminal_reward=10.0).task(scenario).rewards
    ends = {"goal": 10.0, "collision": -10.0, "out_of_bounds": -10.0, "stuck": -10.0}
    assert rewards.model_dump() == scenario.rewards.model_dump() | ends


def test_the_stuck_rule_and_the_collisions_are_the_scenarios_unless_they_are_set():
    scenario = PRESETS["thesis-rewards-2-stuck-1"]
    assert TrainingConfig().task(scenario) == scenario
    assert TrainingConfig(stuck_rule="off").task(scenario).stuck.rule == "off"
    assert TrainingConfig(collision="block").task(scenario).on_collision == "block"


def test_mending_changes_every_switch_and_nothing_else():
    was, mended = TrainingConfig().model_dump(), TrainingConfig(**MENDED).model_dump()
    assert {name for name in was if was[name] != mended[name]} == set(MENDED)
