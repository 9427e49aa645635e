"""Training: reproducible, resumable, on other episodes than evaluation, and effective."""

import json
import os
import signal
from pathlib import Path

import numpy as np
import pytest
import torch

from indoor_explorers.env import PRESETS, InputError
from indoor_explorers.env.provenance import RECORD
from indoor_explorers.env.scenarios.seed_sets import SEED_BLOCK
from indoor_explorers.env.simulation.state import End
from indoor_explorers.evaluation.studies.training import nested
from indoor_explorers.learners.dddqn.config import TrainingConfig
from indoor_explorers.learners.dddqn.learning.learner import Learner
from indoor_explorers.learners.dddqn.learning.vector_flight import VectorFlight
from indoor_explorers.learners.dddqn.network.config import NetworkConfig
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.map_prior import no_prior
from indoor_explorers.learners.dddqn.presets import PRESETS as LEARNED
from indoor_explorers.learners.dddqn.train import Training, evaluate, train
from indoor_explorers.learners.sessions.checkpoint import CHECKPOINT
from indoor_explorers.learners.sessions.session import Progress
from indoor_explorers.learners.sessions.tensorboard import FOLDER
from indoor_explorers.planners.toolbox.networks.tensors import read_tensors
from tests.learners.dddqn.rooms import TINY, assert_same_checkpoints, small_room


def interrupt(progress: Progress) -> None:
    os.kill(os.getpid(), signal.SIGINT)


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Progress]]:
    """The weights of a training with seed 1, and what it reported."""
    seen: list[Progress] = []
    return train(TINY, small_room(), tmp_path_factory.mktemp("trained"), seed=1, report=seen.append), seen


def test_the_same_seed_gives_the_same_weights(trained: tuple[Path, list[Progress]], tmp_path: Path) -> None:
    again, other = (
        train(TINY, small_room(), tmp_path / name, seed=seed).read_bytes() for name, seed in (("a", 1), ("b", 2))
    )
    assert trained[0].read_bytes() == again
    assert again != other


def test_a_resumed_training_equals_an_uninterrupted_one_bit_for_bit(tmp_path: Path) -> None:
    scenario = small_room().with_settings({"team": 2, "radio.model": "square", "radio.range": 3})
    train(TINY, scenario, tmp_path / "whole", seed=1)
    with pytest.raises(KeyboardInterrupt):
        train(TINY, scenario, tmp_path / "cut", seed=1, report=interrupt)
    _, notes = read_tensors(tmp_path / "cut" / CHECKPOINT)
    assert 0 < json.loads(notes["training"])["steps"] < TINY.total_steps
    train(TINY, scenario, tmp_path / "cut", seed=1, resume=True)
    assert_same_checkpoints(tmp_path / "whole", tmp_path / "cut")
    (tmp_path / "cut" / CHECKPOINT).write_bytes(b"nonsense")
    with pytest.raises(InputError, match="expected a safetensors file"):
        train(TINY, scenario, tmp_path / "cut", seed=1, resume=True)


def test_the_record_and_scalars_tell_how_the_weights_were_made(trained: tuple[Path, list[Progress]]) -> None:
    path, seen = trained
    record = json.loads((path.parent / RECORD).read_text())
    assert record["config"] == TINY.model_dump(mode="json")
    assert (record["seed"], record["fingerprint"]) == (1, small_room().fingerprint)
    assert [evaluation["steps"] >= 300 for evaluation in record["evaluations"]] == [True, True]
    assert seen[-1].steps >= seen[-1].total_steps == TINY.total_steps
    assert seen[-1].evaluation == record["evaluations"][-1]
    assert {"numpy", "torch", "python"} <= record["versions"].keys()
    (events,) = (path.parent / FOLDER).iterdir()
    for name in (b"training/loss", b"training/episode_steps", b"evaluation/t_goal"):
        assert name in events.read_bytes()


def test_too_short_a_replay_is_refused() -> None:
    with pytest.raises(InputError, match="raise replay_steps or lower environments"):
        Training(TINY.model_copy(update={"replay_steps": 40}), small_room(), 1)


def test_goals_are_terminal_and_budgets_are_not() -> None:
    training = Training(TINY.model_copy(update={"total_steps": 10**6, "goal": 0.5}), small_room(), 1)
    ends = []
    for _ in range(150):
        training.update()
        slot = (training.replay.written - 1) % len(training.replay.data.action)
        end = training.flight.flights[0].world.state.end.ravel()
        data = training.replay.data
        ends += end[~data.over[slot]].tolist()
        assert np.array_equal(data.terminal[slot], (end == End.GOAL) & ~data.over[slot])
    assert {End.GOAL, End.FLYING} <= set(ends)


def test_a_cut_episode_leaves_its_final_state_and_then_begins_anew() -> None:
    scenario = small_room().with_settings({"budget": 5})
    training = Training(TINY, scenario, 1)
    for _ in range(12):
        training.update()
    data = training.replay.data
    assert np.flatnonzero(data.over[:12, 0]).tolist() == [5, 11]
    assert not data.terminal[:12].any()
    assert np.array_equal(data.over[:12], np.repeat(data.over[:12, :1], 4, axis=1))


def test_exploratory_moves_are_legal_and_marked() -> None:
    training = Training(TINY.model_copy(update={"epsilon_first": 1.0, "epsilon_last": 1.0}), small_room(4), 1)
    for _ in range(60):
        training.update()
    assert training.replay.data.explored[:60].all()
    assert training.flight.flights[0].world.state.collisions.sum() == 0


def test_training_and_evaluation_never_share_an_episode() -> None:
    training = Training(TINY, small_room(), 3)
    for _ in range(200):
        training.update()
    seeds = np.array(training.flight.flights[0].world.seeds)
    assert ((seeds > 7 * SEED_BLOCK) & (seeds < 8 * SEED_BLOCK)).all()
    before = training.flight.tensors()
    copies = {name: array.copy() for name, array in before.items()}
    training.evaluate()
    assert all(np.array_equal(copies[name], array) for name, array in before.items())


def test_a_training_of_some_maps_flies_no_others() -> None:
    training = Training(TINY.model_copy(update={"map_count": 3}), small_room(), 1)
    truths = set()
    for _ in range(60):
        training.update()
        truths |= {room.tobytes() for room in training.flight.flights[0].world.state.truth}
    assert training.episodes > 3
    assert set(training.flight.flights[0].world.seeds) <= set(range(3 * SEED_BLOCK, 3 * SEED_BLOCK + 3))
    assert 1 < len(truths) <= 3


def test_the_schedules_end_where_they_say() -> None:
    config = TrainingConfig()
    assert (config.epsilon(0.0), config.gamma(0.0), config.rate(0.0)) == (0.25, 0.97, 5e-4)
    assert config.epsilon(0.35) == pytest.approx(0.01)
    assert config.gamma(0.5) == config.gamma(1.0) == pytest.approx(0.999)
    assert config.rate(1.0) == pytest.approx(2.5e-5)


def test_the_task_is_the_scenario_with_the_training_rewards() -> None:
    task = TrainingConfig().task(PRESETS["thesis-obstacles"])
    assert (task.goal, task.goal_of, task.denominator, task.stuck.rule) == (0.99, "team", "reachable", "off")
    assert (task.rewards.step, task.rewards.discovered, task.rewards.goal) == (-0.1, 0.1, 1.0)


def test_a_flight_goes_on_from_its_tensors() -> None:
    def fresh() -> VectorFlight:
        seeds = iter(range(100, 200))
        return VectorFlight(small_room(), ObservationConfig(frames=2), no_prior(), 3, lambda: next(seeds))

    first, second = fresh(), fresh()
    for _ in range(9):
        first.observe(np.arange(3))
        first.step(first.moves[:, :, 0].argmin(axis=1))
    second.restore({name: array.copy() for name, array in first.tensors().items()})
    for flight in (first, second):
        flight.observe(np.arange(3))
    assert np.array_equal(first.scenes, second.scenes)
    assert np.array_equal(first.moves, second.moves)


@pytest.mark.slow
def test_a_short_training_explores_better_than_none(tmp_path: Path) -> None:
    threads = torch.get_num_threads()
    config = TrainingConfig(
        network=NetworkConfig(tour_cost=0.0),
        prior_notes=2_000,
        total_steps=24_000,
        environments=16,
        warmup_steps=800,
        batch=64,
        replay_steps=16_000,
        average_rate=0.01,
        target_rate=0.02,
        evaluation_every=12_000,
        evaluation_episodes=40,
    )
    scenario = small_room(0)
    train(config, scenario, tmp_path, seed=1)
    trained = json.loads((tmp_path / RECORD).read_text())["evaluations"][-1]
    untrained = evaluate(Learner(config.observation, config, 1), config.task(scenario), no_prior(), 40, 5, 0)
    assert trained["t_goal"] < 0.6 * untrained.t_goal
    assert torch.get_num_threads() == threads


@pytest.mark.parametrize("name", LEARNED)
def test_presets_are_trainings(name: str) -> None:
    preset = LEARNED[name]
    config = TrainingConfig.model_validate(nested(preset.settings))
    assert config != TrainingConfig()
    assert PRESETS[preset.scenario]
