"""The thesis command: which experiments and versions, what it writes, and that it goes on where it was."""

import csv
import json

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, InputError
from indoor_explorers.evaluation.cli.parser import main
from indoor_explorers.evaluation.studies.thesis.drawing import moving_average, versions_figure
from indoor_explorers.evaluation.studies.thesis.experiments import EXPERIMENTS, chosen, versions
from indoor_explorers.evaluation.studies.thesis.results import COLUMNS, Run
from indoor_explorers.learners.thesis.config import MENDED
from tests.evaluation.studies.inline import inline

SWITCHES = {"terminal_target": "reward", "frame_stack": 4}
QUICK = ("--set", "environments=4", "evaluation_every=2", "evaluation_episodes=2", "memory=64", "batch=8")


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """What a tiny run of one experiment in the empty room and one of a team leaves behind."""
    out = tmp_path_factory.mktemp("thesis") / "out"
    with pytest.MonkeyPatch.context() as patch:
        inline(patch)
        assert run(out, "rewards-2-stuck-1,team-2-radio-3") == 0
    return out


def run(out, only, *more):
    return main(["thesis", "--out", str(out), "--episodes", "3", "--only", only, *QUICK, *more])


def rows(out):
    with (out / "summary.csv").open() as file:
        return list(csv.DictReader(file))


def test_the_experiments_are_those_of_the_thesis():
    assert len(EXPERIMENTS) == 14
    assert all(experiment.scenario in PRESETS for experiment in EXPERIMENTS)
    assert [experiment.episodes(10_000) for experiment in EXPERIMENTS] == [10_000] * 9 + [50_000] * 5
    minutes = {experiment.name: experiment.minutes for experiment in EXPERIMENTS}
    assert (minutes["rewards-1-stuck-0"], minutes["rewards-3-stuck-2"], minutes["team-4-radio-0"]) == (
        100.6,
        35.71,
        421.67,
    )
    for experiment in EXPERIMENTS:
        if experiment.group != "obstacles":
            _, rewards, _, stuck = experiment.name.split("-")
            task = PRESETS[experiment.scenario]
            assert task.rewards.step == {"1": -0.5, "2": -1.0, "3": -10.0}[rewards]
            assert task.stuck.rule == ("off", "no-discovery", "oscillation")[int(stuck)]


def test_a_team_brings_the_uav_whose_weights_it_starts_from():
    assert [one.name for one in chosen(["team-4-*"])] == ["obstacles-1", "team-4-radio-0"]
    assert len(chosen(["*"])) == 14
    with pytest.raises(InputError, match=r"thesis is called 'team-4-radio-1'; did you mean 'team-"):
        chosen(["team-4-radio-1"])


def test_versions_are_the_thesis_the_mended_one_and_single_switches():
    assert versions(["thesis", "mended"], SWITCHES) == {"thesis": {}, "mended": SWITCHES}
    assert versions(["each"], SWITCHES) == {
        "terminal_target": {"terminal_target": "reward"},
        "frame_stack": {"frame_stack": 4},
    }
    with pytest.raises(InputError, match="unknown version 'menden'; did you mean 'mended'"):
        versions(["menden"], SWITCHES)


@pytest.mark.slow
def test_the_table_has_a_row_for_each_training(flown):
    found = rows(flown)
    assert tuple(found[0]) == COLUMNS
    names = ("rewards-2-stuck-1", "obstacles-1", "team-2-radio-3")
    assert [(row["experiment"], row["version"]) for row in found] == [
        (name, version) for name in names for version in ("thesis", "mended")
    ]
    assert [row["episodes"] for row in found] == ["3"] * 2 + ["15"] * 4
    assert {row["team"] for row in found} == {"1", "2"}
    assert all(0 < float(row["coverage"]) <= 1 and float(row["t90"]) <= 400 for row in found)


@pytest.mark.slow
def test_the_versions_differ_in_the_switches_and_teams_start_from_one_uav(flown):
    configs = {
        (name, version): json.loads((flown / name / version / "training.json").read_text())["config"]
        for name in ("obstacles-1", "team-2-radio-3")
        for version in ("thesis", "mended")
    }
    was, mended = configs["obstacles-1", "thesis"], configs["obstacles-1", "mended"]
    assert {name for name in was if was[name] != mended[name]} == {
        *("terminal_target", "advantage_mean", "frame_stack", "identity", "mates", "received_rewarded"),
        "budget_terminal",
    }
    for version in ("thesis", "mended"):
        weights = str((flown / "obstacles-1" / version / "weights.safetensors").resolve())
        assert configs["team-2-radio-3", version]["initial_weights"] == weights


@pytest.mark.filterwarnings("error")
def test_all_versions_of_one_experiment_fit_their_figure():
    names = versions(["thesis", "mended", "each"], MENDED)
    last = {"reached": 0.5, "coverage": 0.7, "t90": 200.0}
    figure = versions_figure([Run(EXPERIMENTS[0], name, {"evaluations": [last]}, np.zeros(1)) for name in names])
    figure.draw_without_rendering()
    panels = [axes.get_window_extent() for axes in figure.axes]
    assert min(min(box.width, box.height) for box in panels) > 100


@pytest.mark.slow
def test_the_page_holds_everything(flown):
    page = (flown / "thesis.html").read_text()
    for word in ("rewards-2-stuck-1", "team-2-radio-3", "124.36 min", "terminal_target", "advantage_mean"):
        assert word in page
    assert page.count("data:image/png;base64,") == 7
    assert "http://" not in page
    assert "https://" not in page
    names = {path.name for path in (flown / "figures").iterdir()}
    groups = ("rewards-2", "obstacles")
    stems = ["versions", *(f"{group}-{figure}" for group in groups for figure in ("scores", "coverage", "greedy"))]
    assert names == {f"{stem}.{ending}" for stem in stems for ending in ("svg", "png")}


@pytest.mark.slow
def test_what_is_finished_is_not_flown_again(flown, monkeypatch):
    before = {path: path.stat().st_mtime_ns for path in flown.rglob("training.json")}
    monkeypatch.setattr("indoor_explorers.evaluation.studies.many_trainings.TrainingProcess", pytest.fail)
    monkeypatch.setattr("indoor_explorers.evaluation.studies.thesis.running.write_figures", lambda runs, folder: None)
    assert run(flown, "rewards-2-stuck-1,team-2-radio-3") == 0
    assert {path: path.stat().st_mtime_ns for path in flown.rglob("training.json")} == before


@pytest.mark.slow
def test_a_folder_of_other_settings_is_refused_in_one_line(flown, capsys):
    assert run(flown, "rewards-2-stuck-1", "--seed", "5") == 2
    line = capsys.readouterr().err
    assert "holds a training with seed 1, expected 5; give the same as then, or another --out" in line
    assert line.count("\n") == 1
    assert run(flown, "rewards-2-stuck-1", "--set", "gamma=0.5") == 2
    assert "holds a training with gamma 0.99, expected 0.5" in capsys.readouterr().err


def test_bad_words_are_told_in_one_line(tmp_path, capsys):
    assert main(["thesis", "--out", str(tmp_path), "--versions", "nonsense"]) == 2
    assert "unknown version 'nonsense'" in capsys.readouterr().err
    assert main(["thesis", "--out", str(tmp_path), "--set", "gama=1"]) == 2
    assert "did you mean 'gamma'" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_moving_average_is_of_so_many_values_in_a_row():
    assert moving_average(np.array([1.0, 2.0, 3.0, 6.0]), 3).tolist() == pytest.approx([2.0, 11 / 3])
    assert moving_average(np.array([1.0, 3.0]), 10).tolist() == [2.0]
