"""The thesis's training: its memory, the schedule of updates, the effect of each switch, and resuming bit for bit."""

import csv
import json

import numpy as np
import pytest
import torch

from indoor_explorers.env import InputError
from indoor_explorers.env.provenance import RECORD
from indoor_explorers.env.scenarios.seed_sets import SEED_BLOCK
from indoor_explorers.env.simulation.state import End
from indoor_explorers.learners.thesis.config import MENDED, TrainingConfig
from indoor_explorers.learners.thesis.train import EPISODES, ThesisTraining, train
from tests.learners.dddqn.rooms import assert_same_checkpoints

from .rooms import TINY, short, write_network


def changed(**settings):
    return TINY.model_copy(update=settings)


def flown(config, scenario, ticks, seed=1):
    training = ThesisTraining(config, scenario, seed)
    for _ in range(ticks):
        training.update()
    return training


class Stop(Exception):
    """Raised from a report to cut a training."""


@pytest.mark.parametrize("settings", [{}, MENDED])
def test_a_training_cut_at_any_moment_goes_on_bit_for_bit(tmp_path, monkeypatch, settings):
    config, scenario = changed(**settings), short("thesis-team-2-radio-3")
    whole = train(config, scenario, tmp_path / "whole", seed=3)
    monkeypatch.setattr(ThesisTraining, "evaluate", _stopping(ThesisTraining.evaluate))
    with pytest.raises(Stop):
        train(config, scenario, tmp_path / "cut", seed=3)
    monkeypatch.undo()
    resumed = train(config, scenario, tmp_path / "cut", seed=3, resume=True)
    assert_same_checkpoints(whole.parent, resumed.parent)
    assert whole.read_bytes() == resumed.read_bytes()
    assert (whole.parent / EPISODES).read_text() == (resumed.parent / EPISODES).read_text()
    assert _evaluations(whole.parent) == _evaluations(resumed.parent)


def _stopping(evaluate):
    """Return an evaluation that stops the training when it is called for the second time."""
    taken = []

    def stop_after(training):
        if taken:
            raise Stop
        taken.append(evaluate(training))
        return taken[-1]

    return stop_after


def _evaluations(folder):
    record = json.loads((folder / RECORD).read_text())
    return record["evaluations"], record["training_coverage_by_step"], record["greedy_coverage_by_step"]


def test_the_files_of_a_training_describe_it(tmp_path):
    seen = []
    scenario = short("thesis-open")
    path = train(TINY, scenario, tmp_path / "out", seed=5, report=seen.append)
    record = json.loads((path.parent / RECORD).read_text())
    with (path.parent / EPISODES).open() as file:
        rows = list(csv.DictReader(file))
    assert record["config"] == TINY.model_dump()
    assert (record["done"], record["seed"], record["fingerprint"]) == (True, 5, scenario.fingerprint)
    assert [row["episode"] for row in rows] == [str(number) for number in range(1, 13)]
    assert {row["end"] for row in rows} <= {"collision", "out_of_bounds", "stuck", "budget", "goal"}
    assert len(record["training_coverage_by_step"]) == max(int(row["steps"]) for row in rows)
    assert seen[-1].episodes >= 12
    assert seen[-1].evaluation["episodes"] == seen[-1].episodes
    assert seen[-1].total_steps >= seen[-1].steps > 0


def test_a_score_is_the_sum_of_an_episodes_rewards():
    training = flown(changed(environments=1), short("thesis-open"), 60)
    data, rows = training.replay.data, training.history.rows
    start = 0
    for score, steps, coverage, end in rows:
        rewards = data.reward[start : start + steps]
        assert score == pytest.approx(float(rewards.sum()))
        assert data.terminal[start : start + steps].tolist() == [False] * (steps - 1) + [True]
        assert rewards[-1] < -300 or end == End.BUDGET
        assert 0 < coverage <= 1
        start += steps
    assert len(rows) > 1


def test_learning_is_due_every_ten_moves_and_copying_by_the_target_interval(monkeypatch):
    config = changed(environments=3, learn_every=10, target_every=50, batch=4)
    training = ThesisTraining(config, short("thesis-open"), 1)
    copies = []
    monkeypatch.setattr(training.learner, "copy_target", lambda: copies.append(training.steps))
    for _ in range(60):
        training.update()
    assert training.steps == 180
    assert len(training.losses) == 18
    assert [steps // 50 for steps in copies] == [1, 2, 3]


def test_the_memory_keeps_the_latest_transitions():
    training = flown(changed(memory=30, learn_every=1000), short("thesis-open"), 40)
    assert training.replay.written == 80
    assert training.replay.filled == 30
    batch = training.replay.sample(30, np.random.default_rng(1))
    assert sorted(batch.reward_B.tolist()) == sorted(training.replay.data.reward.tolist())


@pytest.mark.parametrize("terminal", [True, False])
def test_an_episode_cut_by_its_budget_is_an_end_or_not(terminal):
    settings = {"collision": "block", "stuck_rule": "off", "budget_terminal": terminal, "memory": 100}
    training = flown(changed(**settings, environments=1), short("thesis-open", 7), 21)
    assert [end for *_, end in training.history.rows] == [End.BUDGET] * 3
    assert np.flatnonzero(training.replay.data.terminal).tolist() == ([6, 13, 20] if terminal else [])


def test_a_crash_is_an_end_either_way():
    for terminal in (True, False):
        training = flown(changed(budget_terminal=terminal, environments=1), short("thesis-open", 1000), 60)
        ends = np.cumsum([steps for _, steps, _, _ in training.history.rows]) - 1
        assert np.flatnonzero(training.replay.data.terminal).tolist() == ends.tolist() != []


def test_frames_are_stacked_and_the_first_one_repeated():
    training = flown(changed(frame_stack=3, environments=1, memory=500), short("thesis-open"), 30)
    images, start = training.replay.data.images, 0
    assert images.shape[1] == 4
    for _, steps, _, _ in training.history.rows:
        assert (images[start, :2] == images[start, 2]).all()
        for at in range(start + 1, start + steps):
            assert np.array_equal(images[at, :3], images[at - 1, 1:])
        start += steps


@pytest.mark.parametrize(("mates", "learning"), [("random", 1), ("learn", 2)])
def test_the_moves_of_the_first_uav_or_of_all_are_learned_from(mates, learning):
    training = flown(changed(mates=mates, memory=500), short("thesis-team-2-radio-0"), 1)
    assert training.steps == training.replay.written == 2 * learning
    codes = [set(np.unique(image)) - {0, 1, 2} for image in training.replay.data.images[: training.replay.written, 0]]
    assert codes == ([{3}, {3}] if mates == "random" else [{3}, {4}] * 2)


def test_random_mates_fly_at_random_and_evaluations_fly_all_by_the_network():
    training = flown(changed(epsilon_first=0.01), short("thesis-team-4-radio-0"), 1)
    twin = ThesisTraining(changed(epsilon_first=0.01), short("thesis-team-4-radio-0"), 1)
    for network in (twin.learner.online, twin.learner.target):
        for value in network.parameters():
            value.data.neg_()
    twin.update()
    others = [1, 2, 3, 5, 6, 7]
    cells = [each.flight.world.state.cell.reshape(-1, 2)[others] for each in (training, twin)]
    assert np.array_equal(*cells)
    assert training.evaluate() != twin.evaluate()


def test_mates_and_identity_change_nothing_for_one_uav():
    config = changed(identity=True, mates="learn", received_rewarded=False)
    tensors = [flown(each, short("thesis-open"), 40).learner.tensors() for each in (TINY, config)]
    assert all(np.array_equal(tensors[0][name], tensors[1][name]) for name in tensors[0])


@pytest.mark.parametrize("switch", ["terminal_target", "advantage_mean", "frame_stack", "budget_terminal"])
def test_every_other_switch_changes_what_is_learned(switch):
    settings = {"collision": "block", "stuck_rule": "off"} if switch == "budget_terminal" else {}
    configs = changed(**settings), changed(**settings, **{switch: MENDED[switch]})
    first, second = (flown(config, short("thesis-open", 7), 40).learner.online for config in configs)
    assert not torch.equal(first.second.weight, second.second.weight)


def test_training_and_evaluation_never_share_an_episode():
    training = flown(TINY, short("thesis-open"), 30, seed=3)
    seeds = np.array(training.flight.world.seeds)
    assert ((seeds > 7 * SEED_BLOCK) & (seeds < 8 * SEED_BLOCK)).all()
    before = {name: array.copy() for name, array in training.flight.tensors().items()}
    rng = training.rng.bit_generator.state
    training.evaluate()
    assert all(np.array_equal(before[name], array) for name, array in training.flight.tensors().items())
    assert training.rng.bit_generator.state == rng


def test_a_team_starts_from_the_weights_of_one_uav(tmp_path):
    path = write_network(tmp_path / "alone.safetensors", 9)
    training = ThesisTraining(changed(initial_weights=path), short("thesis-team-2-radio-0"), 1)
    other = ThesisTraining(TINY, short("thesis-team-2-radio-0"), 9)
    weight = other.learner.online.first.weight.detach()
    assert torch.allclose(training.learner.online.first.weight, weight, atol=1e-3)
    assert torch.equal(training.learner.online.first.weight, training.learner.target.first.weight)
    with pytest.raises(InputError, match="expected weights of a network that sees"):
        ThesisTraining(changed(initial_weights=path, frame_stack=4), short("thesis-team-2-radio-0"), 1)


@pytest.mark.slow
def test_a_short_training_learns_to_explore():
    config = TrainingConfig(
        **MENDED | {"frame_stack": 1},
        environments=8,
        batch=32,
        learning_rate=5e-4,
        epsilon_decay=0.999,
        target_every=300,
        learn_every=8,
        evaluation_episodes=30,
    )
    training = ThesisTraining(config, short("thesis-open", 60), 1)
    before = training.evaluate()
    while training.steps < 3500:
        training.update()
    after = training.evaluate()
    assert after["coverage"] > before["coverage"] + 0.1
