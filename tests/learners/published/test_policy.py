"""Policies of published networks: wrong clones and checkpoints are refused, and random weights explore whole maps."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import torch

from indoor_explorers.env import InputError, World, check_policy, scenario
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from tests.learners.published.recorded import POLICIES, drawn_weights, fake_clone


class Trap:
    """Touches a file when it is unpickled."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self):
        return Path.touch, (self.path,)


def damaged(path: Path) -> None:
    path.write_bytes(b"no checkpoint")


def without_policy(path: Path) -> None:
    torch.save({"episode": 3}, path)


def of_another_width(path: Path) -> None:
    weights = drawn_weights("ariadne") | {"pointer.w_key": drawn_weights("ariadne")["pointer.w_key"][:, :64]}
    torch.save({"policy_model": {name: torch.from_numpy(array) for name, array in weights.items()}}, path)


def with_more(path: Path) -> None:
    weights = drawn_weights("ariadne") | {"value.weight": drawn_weights("ariadne")["pointer.w_key"]}
    torch.save({"policy_model": {name: torch.from_numpy(array) for name, array in weights.items()}}, path)


def with_code(path: Path) -> None:
    path.write_bytes(pickle.dumps({"policy_model": Trap(path.with_name("executed"))}))


def with_code_in_a_zip(path: Path) -> None:
    torch.save({"policy_model": Trap(path.with_name("executed"))}, path)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (Path.unlink, "expected the checkpoint, found no file"),
        (damaged, "found"),
        (without_policy, "expected a checkpoint with the entry 'policy_model', found episode"),
        (of_another_width, "expected a policy with 'pointer.w_key' of shape (128, 128), found one of shape (128, 64)"),
        (with_more, "expected a policy without 'value.weight', found one"),
        (with_code, "expected tensors alone, found objects whose reading would execute code"),
        (with_code_in_a_zip, "expected tensors alone, found objects whose reading would execute code"),
    ],
)
def test_another_checkpoint_is_refused_in_one_line(
    change, told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The line says what was expected, what was found, and the command that fetches the right one."""
    clone = fake_clone("ariadne", tmp_path, monkeypatch)
    path = clone / "model/ae_clean/checkpoint.pth"
    change(path)
    with pytest.raises(InputError) as refused:
        POLICIES["ariadne"](path=str(clone))
    line = str(refused.value)
    assert line.startswith(f"{path}: expected")
    assert told in line
    assert f"fetch it with `git -C {clone}/ checkout 8d726ad" in line
    assert line.endswith("-- model/ae_clean/checkpoint.pth`")
    assert "\n" not in line
    assert not path.with_name("executed").exists()


@pytest.mark.parametrize("kind", POLICIES)
def test_another_folder_is_refused_in_one_line(kind: str, tmp_path: Path) -> None:
    policy = POLICIES[kind]
    (tmp_path / next(iter(policy.NETWORK.code.files))).parent.mkdir(exist_ok=True)
    (tmp_path / next(iter(policy.NETWORK.code.files))).write_text("import torch\n")
    told = {"": "expected a clone, as in NAME:DIR, got none", str(tmp_path): "found another", "/no": "found no folder"}
    for folder, words in told.items():
        with pytest.raises(InputError, match=words) as refused:
            policy(path=folder)
        assert policy.NETWORK.code.commit in str(refused.value)


@pytest.mark.slow
@pytest.mark.parametrize("kind", POLICIES)
def test_random_weights_explore_all_in_a_team(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two UAVs with a short radio know every reachable cell at the end, by the guard where the network goes nowhere."""
    policy = POLICIES[kind](path=str(fake_clone(kind, tmp_path, monkeypatch)))
    settings: dict[str, Any] = {
        "map.height": 10,
        "map.width": 10,
        "map.obstacles": 2,
        "team": 2,
        "budget": 900,
        "radio.model": "disc",
        "radio.range": 4.0,
        "denominator": "reachable",
        "goal": 1.0,
    }
    world = World(scenario("thesis-obstacles").with_settings(settings))
    world.reset([3])
    pilots = make_pilots(policy, world)
    for _ in rollout(world, ask_pilots(policy, pilots, world)):
        pass
    assert world.team_coverage[0] == 1.0
    tallies = [pilot.tally() for pilot in pilots.values()]
    assert all(tally["plans"] > tally["choices_without_a_node"] + tally["guarded_choices"] for tally in tallies)
    assert pilots[0, 1].message is not None
    assert policy.provenance()["clone"].startswith("https://github.com/marmotlab/")


@pytest.mark.slow
def test_flying_needs_no_torch_and_executes_nothing_of_the_clone() -> None:
    """Torch reads the checkpoint; importing the policies does not load it."""
    code = "import sys, indoor_explorers.learners.published.policy; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-P", "-c", code], check=False).returncode == 0


@pytest.mark.slow
@pytest.mark.parametrize("kind", POLICIES)
def test_it_passes_the_conformance_suite(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    check_policy(POLICIES[kind](path=str(fake_clone(kind, tmp_path, monkeypatch))))
