from __future__ import annotations

import json
import os
import signal
from pathlib import Path

import numpy as np
import pytest
import torch

from indoor_explorers.env import InputError, World, scenario
from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.policies.view import View
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.evaluation.harness.episodes.stalling import longest_run
from indoor_explorers.learners.attention.flights import drawn_task, fly
from indoor_explorers.learners.attention.graph import FEATURES, TRUE_FEATURES, Graph, GraphSettings
from indoor_explorers.learners.attention.model import PolicyNet, weights_of
from indoor_explorers.learners.attention.network import Loaded, NetworkSettings, load_weights, write_weights
from indoor_explorers.learners.attention.policy import SHIPPED, AttentionPilot, AttentionSac, opened
from indoor_explorers.learners.attention.train import TrainingConfig, train
from indoor_explorers.learners.pockets.maps import TrainingMaps
from indoor_explorers.learners.sessions.session import Progress
from tests.env.conformance.policies import passed_checks

SMALL = NetworkSettings(units=16, heads=2, layers=1)
TINY = TrainingConfig(
    episodes=4,
    first_update=20,
    choices_per_update=20,
    replay=300,
    network=SMALL,
    evaluation_episodes=1,
    evaluation_every=2,
    checkpoint_every=2,
)


@pytest.fixture(name="weights", scope="module")
def _weights(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("attention") / "weights.safetensors"
    write_weights(path, loaded())
    return path


def loaded() -> Loaded:
    torch.manual_seed(1)
    return Loaded(weights_of(PolicyNet(FEATURES, SMALL)), SMALL, GraphSettings())


def small_rooms(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("indoor_explorers.learners.attention.flights.ROOMS", 1.0)


def test_choices_of_a_flight_follow_each_other(monkeypatch: pytest.MonkeyPatch) -> None:
    small_rooms(monkeypatch)
    world = drawn_task(TrainingMaps(), 5, GraphSettings())
    flown = fly(world, loaded(), np.random.default_rng(0), privileged=True)
    assert flown.steps == world.state.step[0] <= world.state.budget[0]
    ends = [each.follows for each in flown.choices if each.follows != 1]
    assert len(ends) == world.scenario.team
    assert flown.choices[-1].follows != 1
    for each in flown.choices:
        assert each.actions[each.chosen] >= 0
        assert each.duration >= 0.0
        assert each.true_features.shape == (len(each.true_neighbours), TRUE_FEATURES)
        np.testing.assert_array_equal(each.true_features[: len(each.features), :FEATURES], each.features)
    total = sum(each.gain for each in flown.choices) * world.scenario.lidar.range**2
    assert total <= world.scenario.team * world.state.truth[0].size


def test_tasks_are_drawn_by_their_seed_alone() -> None:
    first, again, other = (drawn_task(TrainingMaps(), seed, GraphSettings()) for seed in (7, 7, 8))
    assert first.scenario == again.scenario
    assert np.array_equal(first.state.truth, again.state.truth)
    assert first.state.truth.shape != other.state.truth.shape or (first.state.truth != other.state.truth).any()


def test_an_interrupted_training_equals_a_whole_one_bit_for_bit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    small_rooms(monkeypatch)
    train(TINY, None, tmp_path / "whole", seed=2)
    interrupted: list[int | None] = []

    def interrupt(progress: Progress) -> None:
        if progress.episodes in (1, 3) and progress.episodes not in interrupted:
            interrupted.append(progress.episodes)
            os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr("indoor_explorers.learners.sessions.session.REPORT_EVERY", 0.0)
    for _ in range(2):
        with pytest.raises(KeyboardInterrupt):
            train(TINY, None, tmp_path / "cut", seed=2, resume=True, report=interrupt)
    weights = train(TINY, None, tmp_path / "cut", seed=2, resume=True, report=interrupt)
    for name in ("weights.safetensors", "checkpoint.safetensors"):
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "cut" / name).read_bytes()
    whole, cut = (json.loads((tmp_path / folder / "training.json").read_text()) for folder in ("whole", "cut"))
    assert whole["evaluations"] == cut["evaluations"]
    assert [each["episodes"] for each in cut["evaluations"]] == [2, 4]
    assert cut["updates"] > 0
    policy = opened(str(weights.parent))
    assert policy.path == weights
    assert set(policy.seen_seeds()) >= {"training", "validation"}
    with pytest.raises(InputError, match="holds a training with seed 2"):
        train(TINY, None, tmp_path / "cut", seed=3, resume=True)


def test_an_untrained_network_explores_all_with_the_guard(weights: Path) -> None:
    world = World(scenario("small-floors").with_settings({"team": 2, "goal": 1.0, "budget": 4000}))
    world.reset([3])
    policy = AttentionSac(weights=str(weights))
    pilots = make_pilots(policy, world)
    for _ in rollout(world, ask_pilots(policy, pilots, world)):
        pass
    assert world.team_coverage[0] == 1.0
    assert pilots[0, 0].tally()["guarded_choices"] > 0
    assert pilots[0, 1].message is not None


def test_a_goal_is_given_up_once_nothing_unknown_is_in_view_of_it(
    weights: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ends: list[tuple[bool, bool]] = []
    choose = AttentionPilot.choose_goal

    def recorded(pilot: AttentionPilot, view: View) -> None:
        if pilot.goal is not None and not pilot.navigator.is_overdue(view):
            ends.append((view.cell == pilot.goal, pilot.shows_unknown(view, pilot.goal)))
        choose(pilot, view)

    monkeypatch.setattr(AttentionPilot, "choose_goal", recorded)
    world = World(scenario("small-floors").with_settings({"goal": 0.99}))
    world.reset([3])
    policy = AttentionSac(weights=str(weights), guard=False)
    for _ in rollout(world, ask_pilots(policy, make_pilots(policy, world), world)):
        pass
    assert (False, True) not in ends
    assert (False, False) in ends
    assert (True, False) in ends


def test_the_guard_lets_no_uav_fly_to_and_fro(weights: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def nearest(pilot: AttentionPilot, view: View, graph: Graph, allowed: Mask) -> int:
        rows, cols = np.divmod(graph.cells[graph.neighbours[0]], view.belief.shape[1])
        apart = np.abs(rows - view.cell[0]) + np.abs(cols - view.cell[1])
        return int(np.where(allowed, apart, 10_000).argmin())

    monkeypatch.setattr(AttentionPilot, "pick", nearest)
    most = {}
    for guard in (True, False):
        world = World(scenario("small-floors").with_settings({"team": 1, "goal": 1.0, "budget": 300}))
        world.reset([5])
        policy, cells = AttentionSac(weights=str(weights), guard=guard), []
        for _ in rollout(world, ask_pilots(policy, make_pilots(policy, world), world)):
            cells.append(world.state.cell[0, 0].tolist())
        most[guard] = longest_run(np.array([[cells[k] == cells[k + 2]] for k in range(len(cells) - 2)]))
    assert most[True] <= 6 < most[False]


def test_the_trainings_that_ship_are_those_of_their_records() -> None:
    for seed, path in SHIPPED.items():
        policy, record = AttentionSac(training=seed), json.loads(path.with_suffix(".json").read_text())
        assert policy.path == path
        assert record["seed"] == seed
        assert record["learner"] == "attention-sac"
        assert load_weights(path).network == NetworkSettings(**record["config"]["network"])
        assert set(policy.seen_seeds()) >= {"training", "validation"}
    assert len({AttentionSac(training=seed).provenance()["weights_sha256"] for seed in SHIPPED}) == len(SHIPPED)
    with pytest.raises(InputError, match="expected training to be one of 1, 2, 3, got 4"):
        AttentionSac(training=4)


@pytest.mark.slow
def test_it_passes_the_conformance_suite(weights: Path, tmp_path: Path) -> None:
    passed_checks(AttentionSac(weights=str(weights)))
    with pytest.raises(InputError, match="expected a safetensors file, found none"):
        opened(str(tmp_path / "no"))
