"""The train command's settings and presets."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.cli.parser import main
from indoor_explorers.evaluation.studies.training import nested, preset_of


def test_dotted_settings_become_tables() -> None:
    settings = {"batch": 8, "observation.tours": False, "network.width": 32, "observation.crop": 7}
    assert nested(settings) == {
        "batch": 8,
        "observation": {"tours": False, "crop": 7},
        "network": {"width": 32},
    }
    with pytest.raises(InputError, match=r"no setting 'batch\.size', since 'batch' is a single one"):
        nested({"batch": 8, "batch.size": 3})


def test_unknown_presets_and_learners_are_told() -> None:
    with pytest.raises(
        InputError, match=r"unknown preset 'thesis-opne' of learner 'dddqn'; did you mean 'thesis-open'"
    ):
        preset_of("dddqn", "thesis-opne")
    with pytest.raises(InputError, match="unknown learner 'dddq'"):
        preset_of("dddq", "thesis-open")


SMALL = "prior_notes=2000 total_steps=200 environments=4 warmup_steps=40 batch=8 replay_steps=400 evaluation_every=150"
TINY = [*SMALL.split(), "evaluation_episodes=2", "device=cpu", "network.width=16"]


@pytest.mark.slow
def test_the_recipe_of_weights_that_do_not_ship_goes_through(tmp_path: Path) -> None:
    small = [*TINY, "replay_steps=4000", "environments=16"]
    assert main(["train", "--preset", "thesis-team", "--set", *small, "--out", str(tmp_path)]) == 0
    assert json.loads((tmp_path / "training.json").read_text())["done"]
    assert (tmp_path / "weights.safetensors").exists()


@pytest.mark.slow
def test_a_preset_is_trained_with_what_is_set(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["train", "--preset", "thesis-open-map", "--set", *TINY, "--out", str(tmp_path)]) == 0
    record = json.loads((tmp_path / "training.json").read_text())
    assert (record["scenario"]["name"], record["seed"]) == ("thesis-open", 1)
    assert record["config"]["observation"]["tours"] is False
    assert record["config"]["batch"] == 8
    assert "Weights:" in capsys.readouterr().out
