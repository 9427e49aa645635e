"""Stable-Baselines3 and sb3-contrib: trained by one command, flown as ``sb3:DIR``, and told in one line when not."""

import io
import itertools
import json
import os
import pickle
import shutil
import sys
import tempfile
from importlib import import_module
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
import pytest
import torch

from indoor_explorers.env import PRESETS, InputError, World, make_policy
from indoor_explorers.env.interfaces.stable_baselines import StableBaselinesVecEnv
from indoor_explorers.env.scenarios.seed_sets import SEED_BLOCK
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import PolicyChoice, Task
from indoor_explorers.learners.baselines import sb3_ppo
from indoor_explorers.learners.baselines.stable_baselines import StableBaselines
from tests.env.conformance.policies import passed_checks
from tests.learners.baselines.tiny import TINY, cut_and_resume, flown, record_of, refusal, train
from tests.learners.dddqn.rooms import small_room

PACKAGE = "indoor_explorers.learners.baselines"
ON_POLICY = ("total_steps=300", "environments=4", "rollout=16")
OFF_POLICY = ("total_steps=300", "environments=4", "warmup_steps=40", "batch=8", "replay_steps=200")
SETTINGS = {
    "sb3-a2c": ON_POLICY,
    "sb3-dqn": OFF_POLICY,
    "sb3-maskable-ppo": (*ON_POLICY, "batch=32"),
    "sb3-ppo": (*ON_POLICY, "batch=32"),
    "sb3-qrdqn": (*OFF_POLICY, "quantiles=5"),
}


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A folder for each learner; the library leaves no folder of logs in that of temporary files."""
    folders = {learner: tmp_path_factory.mktemp("trained") / learner for learner in SETTINGS}
    temporary = tmp_path_factory.mktemp("temporary")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tempfile, "tempdir", str(temporary))
        for learner, out in folders.items():
            assert train(learner, out, *SETTINGS[learner]) == 0
    assert not list(temporary.glob("SB3-*"))
    return folders


@pytest.fixture
def copy(trained: dict[str, Path], tmp_path: Path) -> Path:
    """A folder to be damaged."""
    return shutil.copytree(trained["sb3-ppo"], tmp_path / "copy")


@pytest.mark.parametrize("learner", SETTINGS)
def test_a_training_says_how_it_was_made(learner: str, trained: dict[str, Path]) -> None:
    record = record_of(trained[learner])
    assert (record["learner"], record["seed"], record["shape"]) == (learner, 3, [8, 8])
    assert record["scenario"]["budget"] == 60
    assert record["config"]["hidden"] == [16]
    assert {"stable-baselines3", "sb3-contrib", "torch", "python"} <= record["versions"].keys()
    assert record["steps"] >= 300
    assert [set(row) for row in record["evaluations"]] == [{"steps", "t90", "t_goal", "missed", "score"}] * 2
    assert not list(trained[learner].glob(".*"))


@pytest.mark.parametrize("learner", SETTINGS)
def test_the_policy_chooses_as_the_library_does(learner: str, trained: dict[str, Path]) -> None:
    """Without our mask, its choice is the library's own ``predict``."""
    policy = StableBaselines(path=str(trained[learner]), mask=False)
    model = import_module(f"{PACKAGE}.{learner.replace('-', '_')}").ALGORITHM.model_class.load(
        trained[learner] / "model.zip", device="cpu"
    )
    world = World(small_room())
    world.reset([5])
    pilot, rng = policy.pilot(world.briefing(0, 0)), np.random.default_rng(0)
    for _ in range(40):
        view = world.view(0, 0)
        assert pilot.act(view) == int(model.predict(pilot.perceive(view), deterministic=True)[0])
        world.step(np.array([[rng.integers(5)]]))


def test_the_pilot_sees_what_training_saw_bit_for_bit(trained: dict[str, Path]) -> None:
    policy = StableBaselines(path=str(trained["sb3-ppo"]))
    config = policy.trained().config
    task = config.task(small_room())
    envs = StableBaselinesVecEnv(2, scenario=task, observation=config.recipe)
    envs.seed(7)
    seen: Any = envs.reset()
    world = World(task, 2)
    world.reset([7, 8])
    pilots = [policy.pilot(world.briefing(b, 0)) for b in range(2)]
    rng = np.random.default_rng(1)
    for _ in range(40):
        for b, pilot in enumerate(pilots):
            assert np.array_equal(pilot.perceive(world.view(b, 0)), np.asarray(seen)[b])
        actions = rng.integers(5, size=2)
        seen, _, over, _ = envs.step(actions)
        world.step(actions[:, None])
        assert not over.any()


def test_the_policy_passes_the_conformance_suite(trained: dict[str, Path]) -> None:
    policy = make_policy(f"sb3:{trained['sb3-qrdqn']}")
    threads = torch.get_num_threads()
    passed_checks(policy)
    assert torch.get_num_threads() == threads
    assert len(pickle.dumps(policy)) < 1000


@pytest.mark.slow
def test_only_with_the_mask_are_all_moves_legal(trained: dict[str, Path]) -> None:
    rng, illegal = np.random.default_rng(0), {True: 0, False: 0}
    world = World(small_room(4).with_settings({"on_collision": "block"}), 20)
    world.reset(range(20))
    policies = [
        StableBaselines(path=str(path), mask=mask) for mask, path in itertools.product((True, False), trained.values())
    ]
    for _ in range(20):
        views = [world.view(b, 0) for b in range(20)]
        for policy in policies:
            chosen = policy.act([policy.pilot(world.briefing(b, 0)) for b in range(20)], views)
            illegal[policy.mask] += sum(not view.legal[action] for view, action in zip(views, chosen, strict=True))
        world.step(rng.integers(5, size=(20, 1)))
    assert illegal[True] == 0
    assert illegal[False] > 0


def test_an_experiment_flies_it_in_a_team_and_gives_a_long_path_a_short_name(
    trained: dict[str, Path], tmp_path: Path
) -> None:
    folder = shutil.copytree(trained["sb3-maskable-ppo"], tmp_path / ("long" * 20))
    choice = PolicyChoice(use=f"sb3:{folder / 'checkpoint.zip'}", parameters={"mask": False})
    assert (len(choice.name), choice.name[:5], choice.name[-14:]) == (80, "sb3:…", "checkpoint.zip")
    task = PRESETS["thesis-team-2"].for_evaluation().with_settings({"budget": 20, "on_collision": "block"})
    (record,) = fly(choice.make(), choice.name, task, [Task(task.name, 0, 1)])
    assert record.steps == 20
    assert choice.make().provenance()["learner"] == "sb3-maskable-ppo"


def test_the_same_seed_gives_the_same_weights(trained: dict[str, Path], tmp_path: Path) -> None:
    train("sb3-ppo", tmp_path / "again", *SETTINGS["sb3-ppo"])
    first, second = (StableBaselines(path=str(out)).trained() for out in (trained["sb3-ppo"], tmp_path / "again"))
    rows = np.random.default_rng(0).random((3, first.record.inputs), np.float32)
    assert np.array_equal(first.scores(rows), second.scores(rows))
    assert first.record.evaluations == second.record.evaluations


@pytest.mark.parametrize("learner", ["sb3-maskable-ppo", "sb3-dqn"])
def test_an_interrupted_training_goes_on(learner: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cut, whole = cut_and_resume(learner, tmp_path / "out", SETTINGS[learner], 100, monkeypatch)
    assert 100 <= cut["steps"] < 300 <= whole["steps"]
    assert whole["evaluations"][-1]["steps"] == whole["steps"]


def test_training_and_evaluation_never_share_an_episode() -> None:
    envs = StableBaselinesVecEnv(3, scenario=small_room(), observation="thesis", first_seed=7 * SEED_BLOCK)
    envs.seed(60)
    envs.reset()
    for _ in range(130):
        seeds = np.array(envs.envs.world.seeds)
        assert ((seeds >= 7 * SEED_BLOCK) & (seeds < 8 * SEED_BLOCK)).all()
        envs.step(np.full(3, 4))


def line_of(capsys: pytest.CaptureFixture[str]) -> str:
    """Return the error that was printed, which is one line."""
    errors = capsys.readouterr().err
    assert errors.count("\n") == 1
    return errors


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((), "already holds a training; give --resume"),
        (("--resume", "--set", "hidden=[8]"), "with hidden [16], expected [8]; give the same as then, or another"),
        (("--resume", "--seed", "4"), "with seed 3, expected 4; give the same as then, or another --out"),
    ],
)
def test_another_training_in_the_folder_is_refused(
    words: tuple[str, ...], message: str, trained: dict[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert train("sb3-ppo", trained["sb3-ppo"], *SETTINGS["sb3-ppo"], words=words) == 2
    assert message in line_of(capsys)


@pytest.mark.parametrize(
    ("learner", "settings", "message"),
    [
        ("sb3-ppo", ("rolout=3",), "unknown key 'rolout'; did you mean 'rollout'?"),
        ("sb3-ppo", ("side=4",), "expected side to be an odd number of cells such as 15, got 4"),
        ("sb3-ppo", ("observation=chanels",), "did you mean 'channels'"),
        ("sb3-ppp", (), "unknown learner 'sb3-ppp'; did you mean 'sb3-ppo'"),
    ],
)
def test_bad_settings_are_one_line(
    learner: str, settings: tuple[str, ...], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert train(learner, tmp_path / "out", *settings) == 2
    assert message in line_of(capsys)
    assert not (tmp_path / "out").exists()


def test_a_team_is_refused_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert train("sb3-ppo", tmp_path / "out", *SETTINGS["sb3-ppo"], team=2) == 2
    assert "expected a scenario with one UAV" in line_of(capsys)
    assert not (tmp_path / "out").exists()


def test_an_observation_of_the_whole_map_needs_maps_of_its_size(tmp_path: Path) -> None:
    train("sb3-a2c", tmp_path / "out", *ON_POLICY, "observation=free+obstacle+self", "total_steps=20")
    policy = make_policy(f"sb3:{tmp_path / 'out'}")
    assert flown(policy, [1]).shape == (30, 1, 2, 2)
    world = World(small_room().with_settings({"map.height": 4, "map.width": 16, "map.obstacles": 0}))
    world.reset([1])
    with pytest.raises(InputError, match="expected a map of 8 x 8 cells as in training, got 4 x 16; train with obser"):
        policy.pilot(world.briefing(0, 0))


def test_other_folders_are_refused_in_one_line(copy: Path, tmp_path: Path) -> None:
    assert "found no training.json in it" in refusal(f"sb3:{tmp_path / 'none'}")
    (copy / "model.zip").write_bytes(b"no zip")
    assert "expected the weights that sb3-ppo trained" in refusal(f"sb3:{copy}")
    (copy / "model.zip").unlink()
    assert "model.zip" in refusal(f"sb3:{copy}")
    (copy / "training.json").write_text(json.dumps(record_of(copy) | {"learner": "rllib-ppo"}))
    assert "got one of rllib-ppo" in refusal(f"sb3:{copy}")
    (copy / "training.json").write_text(json.dumps({"policy": "dddqn"}))
    expected = "expected a training of sb3-a2c, sb3-dqn, sb3-maskable-ppo, sb3-ppo, sb3-qrdqn, got one of dddqn"
    assert expected in refusal(f"sb3:{copy}")
    (copy / "training.json").write_text("{")
    assert "expected JSON" in refusal(f"sb3:{copy}")


def test_a_model_of_another_shape_is_one_line(copy: Path) -> None:
    record = record_of(copy)
    record["config"]["hidden"] = [8]
    (copy / "training.json").write_text(json.dumps(record))
    assert "got something else" in refusal(f"sb3:{copy}")


def test_a_missing_library_is_told_with_its_extra(copy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, f"{PACKAGE}.sb3_ppo")
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    assert "no module named 'stable_baselines3'; install indoor-explorers[sb3]" in refusal(f"sb3:{copy}")


class Bomb:
    def __reduce__(self) -> Any:
        return (Path.touch, (Path(os.environ["BOMB"]),))


def test_nothing_in_a_model_runs(copy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BOMB", str(tmp_path / "gone off"))
    buffer = io.BytesIO()
    torch.save(Bomb(), buffer)
    with ZipFile(copy / "model.zip", "w") as archive:
        archive.writestr("policy.pth", buffer.getvalue())
    assert "expected the weights that sb3-ppo trained" in refusal(f"sb3:{copy}")
    assert not (tmp_path / "gone off").exists()


def test_a_damaged_checkpoint_is_one_line(copy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (copy / "checkpoint.zip").write_bytes(b"no zip")
    assert train("sb3-ppo", copy, *SETTINGS["sb3-ppo"], words=("--resume",)) == 2
    assert "expected a checkpoint of sb3-ppo, got a damaged one" in line_of(capsys)


def test_the_tiny_settings_are_settings_of_every_learner() -> None:
    assert {setting.partition("=")[0] for setting in TINY} <= set(sb3_ppo.TrainingConfig.model_fields)
