"""Trainings of reports: what a choice costs, what is learned from it, and the files of a training."""

import json

import numpy as np
import pytest
import torch

from indoor_explorers.learners.pockets import tasks
from indoor_explorers.learners.pockets.maps import TrainingMaps
from indoor_explorers.learners.reports import flights
from indoor_explorers.learners.reports.flights import (
    TRUE,
    Choice,
    Choices,
    as_arrays,
    fly,
    joined,
    read_choices,
    write_choices,
)
from indoor_explorers.learners.reports.learning import AdvantageNet, advantages, explained, learn_choices, learn_values
from indoor_explorers.learners.reports.network import load_weights, shapes
from indoor_explorers.learners.reports.policy import NAME
from indoor_explorers.learners.reports.situation import NUMBERS, POINTS, Situation
from indoor_explorers.learners.reports.train import ReportsTraining, TrainingConfig, train

SITUATION = Situation(np.zeros(NUMBERS, np.float32), 0.0)


def random_choices(count: int, uav: int = 4) -> Choices:
    """Choices with even odds, ``uav`` of each UAV, one UAV to a flight."""
    rng = np.random.default_rng(1)
    return Choices(
        rng.normal(size=(count, NUMBERS)).astype(np.float32),
        np.zeros(count, np.float32),
        rng.normal(size=(count, TRUE)).astype(np.float32),
        np.full(count, 0.5, np.float32),
        rng.random(count) < 0.5,
        -rng.uniform(0.5, 1.5, count).astype(np.float32),
        rng.uniform(0.5, 2.0, count).astype(np.float32),
        np.full(count // uav, uav),
        np.arange(count // uav),
        rng.uniform(size=(count // uav, 2)),
    )


@pytest.mark.parametrize(("last", "penalty"), [(1.0, 0.0), (0.985, 0.55), (0.5, 1.0)])
def test_rewards_add_up_to_what_the_base_did_not_know_and_what_was_too_late(last, penalty):
    base = np.concatenate([np.linspace(0.1, 0.6, 10), [last]])
    coverage = np.column_stack([base, np.maximum(base, 0.7)])
    choices = [Choice(SITUATION, step, 10 * step, 0.3, step == 4) for step in (2, 4, 9)]
    arrays = as_arrays(choices, coverage, late_cost=20.0, total=1000, team=2, lidar_range=5.0)
    unknown = POINTS * (1.0 - base[3:]).sum() / 10
    assert arrays.rewards.sum() * 1.2 == pytest.approx(-unknown - penalty * 20.0, rel=1e-5)
    assert arrays.durations.tolist() == pytest.approx([0.4, 1.0, 0.2])
    assert arrays.home.tolist() == [False, True, False]
    assert arrays.lengths.tolist() == [3]


def test_a_flight_without_choices_is_kept():
    nothing = as_arrays([], np.ones((11, 2)), 15.0, 10, 1, 5.0)._replace(results=np.array([[1.0, 1.0]]))
    some = random_choices(8)
    whole = joined([nothing, some])
    assert whole.lengths.tolist() == [0, 4, 4]
    assert whole.flight.tolist() == [0, 1, 2]
    assert np.isfinite(learn_values(whole)).all()


def test_advantages_are_returns_less_values_or_single_surprises():
    choices, values = random_choices(8), np.random.default_rng(0).normal(size=8).astype(np.float32)
    whole, next_only = advantages(choices, values, 1.0), advantages(choices, values, 0.0)
    for first in (0, 4):
        rewards = choices.rewards[first : first + 4]
        for k in range(4):
            assert whole[first + k] == pytest.approx(rewards[k:].sum() - values[first + k], rel=1e-4)
            after = values[first + k + 1] if k < 3 else 0.0
            assert next_only[first + k] == pytest.approx(rewards[k] + after - values[first + k], rel=1e-4)
    assert explained(choices, advantages(choices, np.zeros(8, np.float32), 1.0)) == pytest.approx(1.0)


def test_flying_home_becomes_likelier_where_it_was_better():
    torch.manual_seed(0)
    choices, network = random_choices(20_000), AdvantageNet()
    better = choices.numbers[:, 0]
    noise = np.random.default_rng(0).normal(size=20_000)
    learn_choices(network, choices, ((choices.home - 0.5) * better + noise).astype(np.float32))
    with torch.no_grad():
        learned = network(torch.from_numpy(choices.numbers)).squeeze(1).numpy()
    assert np.corrcoef(learned, better)[0, 1] > 0.7


def test_values_predict_the_half_that_they_have_not_seen():
    torch.manual_seed(0)
    choices = random_choices(16_384, uav=1)
    choices = choices._replace(rewards=(5.0 * choices.true[:, 1] - 30.0).astype(np.float32))
    assert explained(choices, learn_values(choices)) > 0.8


def test_a_flight_is_the_same_again_and_survives_its_file(tmp_path):
    network = AdvantageNet().weights()
    first, second = (fly(TrainingMaps(), "frontier-nearest", network, 3.5, 5) for _ in range(2))
    for one, other in zip(first, second, strict=True):
        assert np.array_equal(one, other)
    assert len(first.home) == first.lengths.sum() > 0
    assert (first.rewards <= 0.0).all()
    write_choices(tmp_path / "flights.safetensors", first)
    for one, other in zip(first, read_choices([tmp_path / "flights.safetensors"]), strict=True):
        assert np.array_equal(one, other)


def test_tasks_have_a_base_and_a_deadline():
    rng = np.random.default_rng(0)
    for _ in range(5):
        plan, settings = flights.task(TrainingMaps(), rng)
        free = np.count_nonzero(plan.truth == 1)
        length = settings["budget"] * settings["team"] * settings["lidar.range"] / free
        assert tasks.SHORTEST * 0.95 < length < tasks.LONGEST
        assert settings["base.must_return"]


def test_costs_of_being_late_are_low_in_half_of_the_flights():
    drawn = np.array([flights.draw_late_cost(np.random.default_rng(seed)) for seed in range(400)])
    assert 0.0 <= drawn.min() < 1.0
    assert 250.0 < drawn.max() < 300.0
    assert 15.0 < np.median(drawn) < 35.0


@pytest.mark.slow
def test_a_training_resumed_after_a_round_gives_the_same_weights(tmp_path):
    config = TrainingConfig(rounds=2, flights=4, workers=1, explorer="frontier-nearest")
    whole = load_weights(train(config, None, tmp_path / "whole", seed=3))

    class Stopped(Exception):
        pass

    def stop(progress):
        if progress.evaluation is not None:
            raise Stopped

    with pytest.raises(Stopped):
        train(config, None, tmp_path / "parts", seed=3, report=stop)
    resumed = load_weights(train(config, None, tmp_path / "parts", seed=3, resume=True))
    for one, other in zip(whole, resumed, strict=True):
        assert np.array_equal(one, other)
    record = json.loads((tmp_path / "whole" / "training.json").read_text())
    assert [entry["rounds"] for entry in record["evaluations"]] == [1, 2]
    assert {name: array.shape for name, array in whole._asdict().items()} == shapes()
    assert (tmp_path / "whole" / NAME).is_file()


def test_the_first_network_depends_on_the_seed_alone(tmp_path):
    config = TrainingConfig(explorer="frontier-nearest")
    one, same, other = (
        ReportsTraining(config, seed, tmp_path / str(k)).networks[0] for k, seed in enumerate((1, 1, 2))
    )
    assert np.array_equal(one.first, same.first)
    assert not np.array_equal(one.first, other.first)


def test_an_unknown_explorer_is_refused_before_anything_is_flown():
    with pytest.raises(ValueError, match="unknown policy 'nobody'"):
        TrainingConfig(explorer="nobody")
