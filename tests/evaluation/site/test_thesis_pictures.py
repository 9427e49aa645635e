"""THESIS.md shows the thesis's figures in its order and the measured table, and the file holds what was trained."""

import json
import re

import numpy as np
import pytest

from indoor_explorers.env.simulation.state import End
from indoor_explorers.evaluation.site.pictures.thesis import CIRCLES, circle
from indoor_explorers.evaluation.site.studies import thesis as study
from indoor_explorers.evaluation.site.studies.thesis import STRIDE, measured, pairs, replayed, results_table
from indoor_explorers.evaluation.studies.thesis.drawing import greedy_curve
from tests.documents import ROOT

PAGE = (ROOT / "learners" / "THESIS.md").read_text("utf-8")
AMONG_OBSTACLES = [training for training in measured() if training.moves]


def last(states):
    """The world at the end of a flight."""
    *_, world = states
    return world


def test_the_page_has_the_table():
    assert [row for row in results_table() if row not in PAGE] == []


def test_the_page_has_the_thesis_s_figures_in_its_order():
    numbers = []
    for first, middle, end in re.findall(r"^### 4\.(\d+)(, 4\.|(?: to 4\.))?(\d+)?:", PAGE, re.MULTILINE):
        numbers += range(int(first), int(end or first) + 1)
        assert middle or not end
    assert numbers == list(range(1, 21))


def test_scores_among_obstacles_are_never_positive_and_rise():
    for training in AMONG_OBSTACLES:
        assert training.figures["best_score"] < 0
        assert training.figures["first_score"] < training.figures["training_score"]


def test_uavs_in_contact_act_alike_unless_each_sees_itself():
    for training in AMONG_OBSTACLES:
        alike, linked = training.counted.get("alike_linked"), training.counted["linked"]
        assert (alike is None) == (linked == 0)
        if alike is not None:
            assert alike == 1.0 if training.run.version == "thesis" else 0.5 < alike < 1.0
            told = f"of {linked:.0f} (range" if alike == 1.0 else f"{100 * alike:.0f} % of {linked:.0f}"
            assert told in " ".join(PAGE.split())


def test_the_page_tells_the_share_of_the_uav_of_four_that_saw_most():
    was, mended = (each.counted["most"] for each in AMONG_OBSTACLES if each.run.experiment.name == "team-4-radio-0")
    assert f"it saw {100 * was:.0f} % (mended {100 * mended:.0f} %)" in PAGE


@pytest.mark.parametrize("training", AMONG_OBSTACLES, ids=lambda each: f"{each.run.experiment.name}-{each.run.version}")
def test_a_kept_episode_is_flown_to_its_end(training):
    world = last(replayed(training))
    assert not world.flying.any()
    assert world.scenario.team == len(training.moves)
    assert max(map(len, training.moves)) == world.state.step[0]


def test_the_shipped_weights_fly_a_round_or_end_as_stuck():
    worlds = [last(circle(seed)) for seed in CIRCLES]
    assert [End(int(world.state.end[0, 0])) for world in worlds] == [End.GOAL, End.STUCK, End.STUCK]
    coverage = [float(world.team_coverage[0]) for world in worlds]
    assert min(coverage[:2]) > 0.85 > coverage[2]


def test_the_file_has_both_versions_of_a_training():
    assert pairs()
    for one, other in pairs():
        assert (one.run.version, other.run.version) == study.VERSIONS
        assert len(one.run.scores) == len(other.run.scores) == 500


def test_a_row_is_what_was_trained(tmp_path, monkeypatch):
    folder = tmp_path / "rewards-1-stuck-2" / "thesis"
    folder.mkdir(parents=True)
    scores, curve = np.linspace(-400, 100, 50), np.linspace(0.1, 0.9, 4 * STRIDE + 1)
    evaluation = {"episodes": 50, "coverage": 0.7, "t90": 390.0, "reached": 0.25, "crashed": 0.5, "stuck": 0.25}
    record = {"done": True, "seed": 7, "commit": "0123456789", "seconds": 1.0, "evaluations": [evaluation]}
    record |= {"scenario": {"team": 1}, **dict.fromkeys(study.CURVES, curve.tolist())}
    (folder / "training.json").write_text(json.dumps(record))
    (folder / "episodes.csv").write_text("score\n" + "\n".join(map(str, scores)))
    monkeypatch.setattr(study, "MEASURED", tmp_path / "thesis.csv")
    study.main([str(tmp_path), str(tmp_path)], study.MEASURED)
    (training,) = measured.__wrapped__()
    assert (training.seed, training.every, training.moves) == (7, 1, ())
    assert training.run.scores == pytest.approx(scores, abs=0.5)
    assert greedy_curve(training.run)[: len(curve)] == pytest.approx(curve, abs=1e-3)
    assert training.run.greedy("crashed").tolist() == [0.5]
    assert training.figures["best_score"] == 100
    assert training.figures["training_score"] == pytest.approx(scores[-5:].mean(), abs=0.01)
    assert "--episodes 50 --seed 7 --only rewards-1-stuck-2 --versions thesis,0123456" in study.MEASURED.read_text()
