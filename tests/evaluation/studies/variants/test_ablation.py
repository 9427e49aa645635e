"""The ablate command: tiny trainings of two variants with two seeds, and what is made of them."""

import csv
import json
import os
import signal
import threading
from pathlib import Path

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, InputError
from indoor_explorers.env.provenance import RECORD
from indoor_explorers.env.scenarios.validation import validated
from indoor_explorers.evaluation.cli.parser import main
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.studies import many_trainings
from indoor_explorers.evaluation.studies.many_trainings import Training, train_all
from indoor_explorers.evaluation.studies.training import nested
from indoor_explorers.evaluation.studies.variants.ablation import COLUMNS, runs_of, write_table
from indoor_explorers.evaluation.studies.variants.ablation_drawing import on_one_grid
from indoor_explorers.evaluation.studies.variants.scoring import VariantScore
from indoor_explorers.learners.dddqn import train as dddqn
from tests.evaluation.studies.inline import Inline, inline
from tests.evaluation.studies.variants.requests import TINY, small_room, study_request

BROKEN = {"broken": {"replay_steps": 40}}


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    return small_room(tmp_path_factory.mktemp("room"))


@pytest.fixture(scope="module")
def trained(tmp_path_factory, room):
    """What a run of two variants leaves behind, a third of which fails."""
    out = tmp_path_factory.mktemp("ablation") / "out"
    with pytest.MonkeyPatch.context() as patch:
        inline(patch)
        patch.setattr(dddqn, "ABLATIONS", {**dddqn.ABLATIONS, **BROKEN})
        assert run(out, room, "no-visits", "broken") == 1
    return out


def run(out, room, *only, seeds="2", more=()):
    words = ["--scenario", str(room), "--only", *only, "--seeds", seeds, "--episodes", "6", "--set", *TINY, *more]
    return main(["ablate", *words, "--out", str(out)])


def rows(out):
    with (out / "ablation.csv").open(newline="") as file:
        return {row["variant"]: row for row in csv.DictReader(file)}


def test_every_variant_is_a_training_of_its_own():
    configs = {
        name: validated(dddqn.TrainingConfig, nested(settings), name)
        for name, settings in {**dddqn.ABLATIONS, **dddqn.TEAM_ABLATIONS}.items()
    }
    assert configs["full"] == dddqn.TrainingConfig()
    assert len({config.model_dump_json() for config in configs.values()}) == len(configs)


def test_only_what_is_asked_for_is_trained_and_teams_have_more(tmp_path):
    def names(team, *patterns):
        task = PRESETS["thesis-open"].with_settings({"team": team})
        found = runs_of(study_request(tmp_path, scenario_name="thesis-open", scenario=task, patterns=patterns))
        return [(run.variant, run.seed) for run in found]

    wanted = ("full", "1-step", "no-tour-start", "no-tours")
    assert names(1, "no-t*", "1-step") == [(name, seed) for seed in (1, 2) for name in wanted]
    assert names(2, "mates")[:2] == [("full", 1), ("mates", 1)]
    with pytest.raises(InputError, match="no variant is called 'mates'"):
        names(1, "mates")


@pytest.mark.slow
def test_the_table_tells_what_was_flown(trained):
    found, results = rows(trained), Results.load(trained / "judged")
    assert list(found) == ["full", "no-visits"]
    means = {
        variant: [results.values("room", f"{variant}, seed {seed}", "t99").mean() for seed in (1, 2)]
        for variant in found
    }
    row = found["no-visits"]
    assert tuple(row) == COLUMNS
    assert row["seeds"] == "2"
    assert float(row["t99"]) == pytest.approx(np.mean(means["no-visits"]), abs=6e-4)
    assert float(row["t99_to_full"]) == pytest.approx(np.mean(means["no-visits"]) - np.mean(means["full"]), abs=2e-3)
    assert float(row["t99_to_full_low"]) <= float(row["t99_to_full"]) <= float(row["t99_to_full_high"])
    assert found["full"]["t99_to_full"] == ""
    assert 0 <= float(row["never_99_percent"]) <= 100
    assert json.loads(row["settings"])["observation.visits"] is False
    assert {record.task.seed for record in results.records} == set(range(2**39, 2**39 + 6))


@pytest.mark.slow
def test_the_figure_is_there_in_every_format(trained):
    starts = {"svg": b"<?xml", "png": b"\x89PNG", "pdf": b"%PDF"}
    assert {path.name for path in (trained / "figures").iterdir()} == {f"ablation.{ending}" for ending in starts}
    for ending, start in starts.items():
        assert (trained / "figures" / f"ablation.{ending}").read_bytes().startswith(start)


@pytest.mark.slow
def test_a_variant_that_fails_leaves_the_others_alone(trained):
    for variant in ("full", "no-visits"):
        for seed in (1, 2):
            assert json.loads((trained / variant / f"seed-{seed}" / RECORD).read_text())["done"]
    assert not list((trained / "broken").rglob("weights.safetensors"))


@pytest.mark.slow
def test_what_is_finished_is_not_trained_again_and_seeds_may_be_added(trained, room, monkeypatch):
    inline(monkeypatch)
    begun = []
    noted = lambda run, shown: begun.append(run.title) or Inline(run, shown=shown)  # noqa: E731
    monkeypatch.setattr(many_trainings, "TrainingProcess", noted)
    before = (trained / "ablation.csv").read_bytes()
    assert run(trained, room, "no-visits") == 0
    assert begun == []
    assert (trained / "ablation.csv").read_bytes() == before
    assert run(trained, room, "full", seeds="3") == 0
    assert begun == ["full, seed 3"]
    assert rows(trained)["full"]["seeds"] == "3"


@pytest.mark.slow
def test_another_ablation_in_the_folder_is_refused_in_one_line(trained, room, capsys):
    assert run(trained, room, "no-visits", more=["batch=16"]) == 2
    line = capsys.readouterr().err
    assert "holds a training with batch 8, expected 16; give the same as then, or another --out" in line
    assert line.count("\n") == 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--only", "no-turs"], "no variant is called 'no-turs'; did you mean 'no-tours'"),
        (["--learner", "sb3-dqn"], "expected a learner that declares ABLATIONS, as dddqn does, got 'sb3-dqn'"),
        (["--set", "bach=1"], "did you mean 'batch'"),
        (["--scenario", "thesis-opne"], "did you mean 'thesis-open'"),
        (["--seeds", "0"], "a whole number of at least 1"),
    ],
)
def test_bad_words_are_told_in_one_line(words, said, tmp_path, capsys):
    assert main(["ablate", *words, "--out", str(tmp_path / "out")]) == 2
    line = capsys.readouterr().err
    assert said in line
    assert line.count("\n") == 1
    assert not (tmp_path / "out").exists()


def order_of(folder: Path, room: Path, **settings) -> Training:
    tiny = {"environments": 4, "warmup_steps": 40, "batch": 8, "replay_steps": 400, "evaluation_episodes": 2}
    return Training("dddqn", str(room), "full", 1, {**tiny, "device": "cpu", **settings}, str(folder))


@pytest.mark.slow
def test_a_process_tells_why_it_failed_and_goes_on_where_it_was_interrupted(tmp_path, room):
    (failure,) = train_all([order_of(tmp_path / "bad", room, replay_steps=40)], 1, lambda line: None)
    assert "raise replay_steps or lower environments" in failure.reason
    long = order_of(tmp_path / "long", room, total_steps=10**9, checkpoint_every=200)
    checkpoint = tmp_path / "long" / "checkpoint.safetensors"
    stop = threading.Event()

    def interrupt():
        while not checkpoint.exists() and not stop.wait(0.1):
            pass
        os.kill(os.getpid(), signal.SIGINT)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it
    watcher = threading.Thread(target=interrupt)
    watcher.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            train_all([long], 1, lambda line: None)
    finally:
        stop.set()
        watcher.join()
        signal.signal(signal.SIGINT, before)
    note = json.loads((tmp_path / "long" / RECORD).read_text())
    assert note["seconds"] > 0
    assert not note["done"]


def test_differences_are_paired_by_map_and_counted_over_seeds(tmp_path):
    def variant(variant, times):
        values = np.array(times, np.float64)
        return VariantScore(
            variant=variant,
            settings={"batch": 8},
            seeds=[1, 2],
            times={"t90": values / 2, "t99": values},
            never=0.25,
            minutes=1.5,
            curves=[],
        )

    full = variant("full", [[1, 2, 3, 2, 2], [1, 2, 3, 2, 2]])
    other = variant("other", [[4, 6, 8, 6, 6], [6, 8, 10, 8, 8]])
    write_table([full, other], tmp_path / "ablation.csv")
    row = rows(tmp_path)["other"]
    assert (row["t90"], row["t99"], row["t90_to_full"], row["t99_to_full"]) == ("3.500", "7.000", "2.500", "5.000")
    assert (row["never_99_percent"], row["minutes"]) == ("25.000", "1.50")
    assert other.dots(full, "t99").tolist() == [4.0, 6.0]


def test_curves_meet_on_the_moves_that_all_have():
    curves = [np.array([[0.0, 10.0, 20.0], [5.0, 3.0, 1.0]]), np.array([[5.0, 15.0], [4.0, 2.0]])]
    moves, values = on_one_grid(curves)
    assert moves.tolist() == [5.0, 10.0, 15.0]
    assert values.tolist() == [[4.0, 3.0, 2.0], [4.0, 3.0, 2.0]]
