"""Several scenarios in one training: each is flown as it would be flown alone."""

import os
import signal
from collections.abc import Callable
from itertools import count
from pathlib import Path

import numpy as np
import pytest

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.learners.dddqn.config import TrainingConfig
from indoor_explorers.learners.dddqn.learning.multi_task_flight import MultiTaskFlight, shares
from indoor_explorers.learners.dddqn.learning.vector_flight import VectorFlight
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.map_prior import no_prior
from indoor_explorers.learners.dddqn.observation.scales import sensor
from indoor_explorers.learners.dddqn.train import Training, train
from indoor_explorers.learners.sessions import session
from indoor_explorers.learners.sessions.evaluation import Evaluation, mean_evaluation
from indoor_explorers.learners.sessions.record import TrainingRecord, read_record
from indoor_explorers.learners.sessions.session import Progress
from tests.learners.dddqn.rooms import TINY, assert_same_checkpoints, small_room

SIGHT = ObservationConfig(layers=("unknown", "free", "mates"), tours=False)


def hall() -> Scenario:
    """A wider room for two, with another lidar and radio."""
    return small_room().with_settings(
        {"map.width": 13, "team": 2, "lidar.range": 6.5, "radio.model": "square", "radio.range": 4, "budget": 30}
    )


def numbers() -> Callable[[], int]:
    seeds = count(100)
    return lambda: next(seeds)


def with_hall(tmp_path: Path) -> TrainingConfig:
    path = tmp_path / "hall.toml"
    path.write_text(hall().to_toml())
    return TINY.model_copy(update={"observation": SIGHT, "also": (str(path),), "environments": 8})


def test_environments_are_shared_out() -> None:
    assert shares(2, 1) == [2]
    assert shares(16, 3) == [5, 5, 6]
    assert shares(6, 2) == [4, 4]


def test_flights_fly_like_each_alone() -> None:
    tasks, rng = [TINY.task(small_room()), TINY.task(hall())], np.random.default_rng(1)
    together, seeds = MultiTaskFlight(tasks, SIGHT, no_prior(), 8, numbers()), numbers()
    alone = [VectorFlight(task, SIGHT, no_prior(), 4, seeds) for task in tasks]
    assert together.columns == 4 + 8
    for _ in range(12):
        together.observe()
        for flight in alone:
            flight.observe(np.arange(flight.columns))
        for name in ("scene", "scenes", "moves", "over", "terminal", "age", "coverage"):
            expected = np.concatenate([getattr(flight, name) for flight in alone])
            assert np.array_equal(getattr(together, name), expected), name
        actions = (rng.random((12, 4)) - together.moves[:, :, 0]).argmax(axis=1)
        rewards = [flight.step(part) for flight, part in zip(alone, (actions[:4], actions[4:]), strict=True)]
        assert np.array_equal(together.step(actions), np.concatenate(rewards))
    assert together.repeat([1.0, 2.0]).tolist() == 4 * [1.0] + 8 * [2.0]


def test_only_episodes_that_all_have_ended_begin_anew() -> None:
    flights = MultiTaskFlight([small_room(), hall()], SIGHT, no_prior(), 8, numbers())
    flights.observe()
    flights.step(flights.moves[:, :, 0].argmin(axis=1))
    over = np.zeros(12, np.bool_)
    over[[1, 4, 6, 7]] = True  # one of the first two of the hall flies on
    assert flights.renew(over) == [1, 1]
    assert np.flatnonzero(flights.age == 0).tolist() == [1, 6, 7]


def test_a_training_on_several_scenarios_resumes_bit_for_bit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(session, "REPORT_EVERY", 0.0)
    config = with_hall(tmp_path)
    whole = train(config, small_room(), tmp_path / "whole", seed=1)
    cut = tmp_path / "cut"

    def interrupt(progress: Progress) -> None:
        if progress.evaluation is not None:
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        train(config, small_room(), cut, seed=1, report=interrupt)
    assert 300 <= read_record(cut, TrainingRecord, ["dddqn"]).steps < 400
    assert train(config, small_room(), cut, seed=1, resume=True).read_bytes() == whole.read_bytes()
    assert_same_checkpoints(tmp_path / "whole", cut)
    with pytest.raises(InputError, match=r"holds a training with task .*, expected"):
        train(config.model_copy(update={"also": ()}), small_room(), cut, seed=1, resume=True)


def test_a_scenario_that_there_is_not_is_refused() -> None:
    with pytest.raises(InputError, match="unknown scenario 'maize'"):
        Training(TINY.model_copy(update={"also": ("maize",)}), small_room(), 1)


def test_rewards_are_scaled_by_the_lidar() -> None:
    plain, scaled = TINY, TINY.model_copy(update={"scale_rewards": True})
    assert scaled.task(small_room()) == plain.task(small_room())
    assert scaled.early_step(small_room()) == plain.early_step(small_room()) == plain.reward_early_step
    rewards, lens = scaled.task(hall()).rewards, sensor(6.5)
    assert rewards.discovered == pytest.approx(0.1 * sensor(3.0).disc / lens.disc)
    assert rewards.step == pytest.approx(-0.1 * 3 / 6.5)
    assert scaled.early_step(hall()) == pytest.approx(-0.1 * 3 / 6.5)
    assert rewards.goal == plain.reward_goal


def test_evaluations_are_averaged() -> None:
    found = [Evaluation(7, 10.0, 20.0, 0.0, 0.5), Evaluation(7, 30.0, 50.0, 0.5, 1.0)]
    assert mean_evaluation(found) == (7, 20.0, 35.0, 0.25, 0.75)
