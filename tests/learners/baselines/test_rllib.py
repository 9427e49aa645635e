"""RLlib: a team trained by one command with shared parameters, flown as ``rllib:DIR``."""

import json
import shutil
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from indoor_explorers.env import World, check_policy, make_policy
from indoor_explorers.env.scenarios.seed_sets import SEED_BLOCK
from indoor_explorers.learners.baselines.rllib import Rllib
from tests.learners.baselines.tiny import cut_and_resume, flown, record_of, refusal, train
from tests.learners.dddqn.rooms import small_room

pytestmark = pytest.mark.xdist_group("ray")
PPO = ("total_steps=300", "environments=2", "rollout=80", "batch=40", "epochs=1")
SAC = ("total_steps=300", "environments=2", "warmup_steps=40", "batch=8", "replay_steps=400", "intensity=1.0")
PAIR = {"team": 2, "radio.model": "unlimited"}


def training_team(*arguments: Any) -> Any:
    """Return the environment of a training; Ray is imported late, since every process of pytest collects this file."""
    from ray.rllib.env.wrappers.pettingzoo_env import ParallelPettingZooEnv

    from indoor_explorers.learners.baselines.rllib_training import TrainingTeam

    return ParallelPettingZooEnv(TrainingTeam(*arguments))


@pytest.fixture(scope="module")
def trained(connected: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a PPO of two UAVs."""
    out = tmp_path_factory.mktemp("trained") / "ppo"
    assert train("rllib-ppo", out, *PPO, team=2) == 0
    return out


@pytest.mark.slow
def test_a_training_says_how_it_was_made(trained: Path) -> None:
    record = record_of(trained)
    assert (record["learner"], record["scenario"]["team"], record["shape"]) == ("rllib-ppo", 2, [8, 8])
    assert {"ray", "torch", "pettingzoo"} <= record["versions"].keys()
    assert 300 <= record["steps"] < 500
    assert record["evaluations"][-1]["steps"] == record["steps"]
    assert {path.name for path in trained.iterdir()} == {"checkpoint", "training.json", "weights.safetensors"}
    import ray

    assert ray.is_initialized()


@pytest.mark.slow
@pytest.mark.parametrize("mask", [True, False])
def test_the_pilots_see_what_training_saw_bit_for_bit(mask: bool, trained: Path) -> None:
    from indoor_explorers.learners.baselines.rllib_ppo import TrainingConfig

    config = TrainingConfig(side=5, zones=2, hidden=(16,), mask=mask)
    task = config.task(small_room().with_settings(PAIR))
    team = training_team(task, config.environment_recipe, count(7))
    seen, _ = team.reset(seed=99)
    world = World(task)
    world.reset(team.par_env.world.seeds)
    policy = Rllib(path=str(trained))
    pilots = [policy.pilot(world.briefing(0, n)) for n in range(2)]
    rng = np.random.default_rng(1)
    heard = 0
    for _ in range(50):
        for n, pilot in enumerate(pilots):
            view, observed = world.view(0, n), seen[f"uav_{n}"]
            if mask:
                assert np.array_equal(observed["action_mask"], view.legal)
                observed = observed["observations"]
            assert np.array_equal(pilot.perceive(view), observed)
            heard += bool(view.mates)
        actions = rng.integers(5, size=2)
        seen, *_ = team.step({f"uav_{n}": int(actions[n]) for n in range(2)})
        world.step(actions[None])
    assert heard > 0


@pytest.mark.slow
def test_the_policy_passes_the_conformance_suite(trained: Path) -> None:
    check_policy(make_policy(f"rllib:{trained}"))


@pytest.mark.slow
def test_the_masking_network_gives_illegal_moves_no_chance(trained: Path) -> None:
    from indoor_explorers.learners.baselines.rllib_ppo import TrainingConfig

    policy = Rllib(path=str(trained))
    config = policy.trained().config
    assert isinstance(config, TrainingConfig)
    module = config.untrained(policy.trained().record.inputs)
    rows = torch.rand(6, policy.trained().record.inputs)
    legal = torch.tensor([[1, 0, 1, 0, 1]] * 6)
    batch = {"obs": {"observations": rows, "action_mask": legal}}
    chances = module.forward_exploration(batch)["action_dist_inputs"].softmax(dim=1)
    assert (chances[:, [1, 3]] == 0).all()
    assert (chances[:, [0, 2, 4]] > 0).all()
    assert set(batch["obs"]) == {"observations", "action_mask"}


@pytest.mark.slow
@pytest.mark.usefixtures("connected")
def test_an_interrupted_training_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cut, whole = cut_and_resume("rllib-ppo", tmp_path / "out", PPO, 50, monkeypatch)
    assert 50 <= cut["steps"] < 300 <= whole["steps"] < 300 + 80 + cut["steps"]


@pytest.mark.slow
@pytest.mark.usefixtures("connected")
def test_discrete_sac_trains_and_flies(tmp_path: Path) -> None:
    assert train("rllib-sac", tmp_path / "out", *SAC, team=2) == 0
    assert flown(make_policy(f"rllib:{tmp_path / 'out'}"), [1, 2]).shape == (30, 2, 2, 2)


def test_episodes_of_a_training_are_its_own() -> None:
    team = training_team(small_room(), "thesis", count(SEED_BLOCK))
    seeds = []
    for _ in range(3):
        team.reset(seed=5)
        seeds += team.par_env.world.seeds
    assert seeds == [SEED_BLOCK + 1 + k for k in range(3)]  # RLlib's wrapper begins one by itself


@pytest.mark.slow
def test_other_folders_are_refused_in_one_line(
    trained: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copy = shutil.copytree(trained, tmp_path / "copy")
    assert "found no training.json in it" in refusal(f"rllib:{tmp_path / 'none'}")
    (copy / "weights.safetensors").write_bytes(b"no tensors")
    assert "expected the weights that rllib-ppo trained" in refusal(f"rllib:{copy}")
    (copy / "weights.safetensors").unlink()
    assert "weights.safetensors" in refusal(f"rllib:{copy}")
    (copy / "training.json").write_text(json.dumps(record_of(copy) | {"learner": "sb3-ppo"}))
    assert "got one of sb3-ppo" in refusal(f"rllib:{copy}")
    shutil.copy(trained / "training.json", copy)
    (copy / "checkpoint" / "moves.txt").write_text("many")
    assert train("rllib-ppo", copy, *PPO, team=2, words=("--resume",)) == 2
    errors = capsys.readouterr().err
    assert "expected a checkpoint of RLlib, got a damaged one" in errors
