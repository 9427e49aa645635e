"""The scale command: tiny trainings along two axes, and what is made of them."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest

from indoor_explorers.env import InputError
from indoor_explorers.env.scenarios.validation import validated
from indoor_explorers.evaluation.cli.parser import main
from indoor_explorers.evaluation.studies.training import nested
from indoor_explorers.evaluation.studies.variants.scaling import COLUMNS, levels, row, runs_of
from indoor_explorers.evaluation.studies.variants.scaling_drawing import positions, scaling_figure
from indoor_explorers.evaluation.studies.variants.scoring import VariantScore
from indoor_explorers.learners.dddqn import train as dddqn
from indoor_explorers.learners.places import train as places
from tests.evaluation.studies.inline import inline
from tests.evaluation.studies.variants.requests import TINY, small_room, study_request

TWO_BUDGETS = {"steps-100": {"total_steps": 100}, "steps-200": {"total_steps": 200}, "maps-2": {"map_count": 2}}
TWO_AXES = {"moves in training": {100: "steps-100", 200: "steps-200"}, "maps": {2: "maps-2", math.inf: "steps-200"}}


@pytest.mark.parametrize("learner", [dddqn, places])
def test_each_level_of_an_axis_is_a_training_of_its_own(learner):
    configs = {name: validated(learner.TrainingConfig, nested(each), name) for name, each in learner.SCALING.items()}
    assert len({config.model_dump_json() for config in configs.values()}) == len(configs)
    named = [name for by_level in learner.SCALING_AXES.values() for name in by_level.values()]
    assert set(named) == set(configs)
    assert all(len(by_level) >= 3 for by_level in learner.SCALING_AXES.values())


def test_learners_that_draw_their_own_tasks_train_without_a_scenario(tmp_path):
    runs = runs_of(study_request(tmp_path, learner="dddqn-places", patterns=("flights-*",), seeds=1))
    assert [(run.scenario, run.settings["flights"]) for run in runs] == [(None, each) for each in (12, 50, 200, 800)]
    with pytest.raises(InputError, match="expected a learner that declares SCALING, as dddqn does, got 'pockets'"):
        runs_of(study_request(tmp_path, learner="pockets"))


@pytest.mark.slow
def test_what_was_trained_is_flown_tabled_and_drawn(tmp_path, monkeypatch):
    inline(monkeypatch)
    monkeypatch.setattr(dddqn, "SCALING", TWO_BUDGETS)
    monkeypatch.setattr(dddqn, "SCALING_AXES", TWO_AXES)
    out = tmp_path / "out"
    words = ["--scenario", str(small_room(tmp_path)), "--seeds", "2", "--episodes", "6", "--set", *TINY]
    assert main(["scale", *words, "--out", str(out)]) == 0
    with (out / "scaling.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(each["axis"], each["level"], each["variant"]) for each in rows] == [
        ("moves in training", "100", "steps-100"),
        ("moves in training", "200", "steps-200"),
        ("maps", "2", "maps-2"),
        ("maps", "unlimited", "steps-200"),
    ]
    assert {each["seeds"] for each in rows} == {"2"}
    assert {path.name for path in (out / "figures").iterdir()} == {f"scaling.{end}" for end in ("svg", "png", "pdf")}
    assert (out / "steps-200" / "seed-2" / "weights.safetensors").is_file()


def some_score(variant: str, steps: float) -> VariantScore:
    times = np.linspace(steps, steps + 10, 12).reshape(2, 6)
    return VariantScore(
        variant=variant,
        settings={},
        seeds=[1, 2],
        times={"t90": times / 2, "t99": times},
        never=0.5,
        minutes=2.0,
        curves=[],
    )


def test_unfinished_levels_are_left_out_and_rows_tell_means():
    found = levels(TWO_AXES, [some_score("steps-100", 40.0), some_score("maps-2", 90.0)])
    assert {axis: list(by_level) for axis, by_level in found.items()} == {"moves in training": [100], "maps": [2]}
    told = row("maps", math.inf, some_score("steps-200", 30.0))
    assert tuple(told) == COLUMNS
    assert (told["level"], told["t99"], told["t90"], told["never_99_percent"]) == (
        "unlimited",
        "35.000",
        "17.500",
        "50.000",
    )


def test_a_level_without_a_limit_is_a_step_beyond_the_largest():
    assert positions([16, 256, 4096, math.inf]).tolist() == [16, 256, 4096, 65536]
    assert positions([16, math.inf]).tolist() == [16, 64]


def test_the_figure_draws_every_level_and_training():
    scores = [some_score("steps-100", 80.0), some_score("steps-200", 30.0), some_score("maps-2", 90.0)]
    figure = scaling_figure(levels(TWO_AXES, scores), "room")
    first, second = figure.axes
    assert [line.get_xydata().round(9).tolist() for line in first.lines if line.get_label() == "T99"] == [
        [[100.0, 85.0], [200.0, 35.0]]
    ]
    assert [text.get_text() for text in second.get_xticklabels()] == ["2", "no limit"]
    dots = np.concatenate([points.get_offsets() for points in first.collections])
    assert len(dots) == 2 * 2 * 2  # levels, times, trainings


def test_bad_words_are_told_in_one_line(tmp_path: Path, capsys):
    assert main(["scale", "--only", "stps-46875", "--out", str(tmp_path / "out")]) == 2
    line = capsys.readouterr().err
    assert "no variant is called 'stps-46875'; did you mean 'steps-46875'" in line
    assert line.count("\n") == 1
    assert not (tmp_path / "out").exists()
