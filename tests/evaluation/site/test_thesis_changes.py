"""THESIS.md has the picture and the table of two changes to its learner, and the file holds what was trained."""

import json
import re

import numpy as np

from indoor_explorers.evaluation.site.studies import thesis_changes as study
from indoor_explorers.learners.thesis.config import MENDED, TrainingConfig
from tests.documents import ROOT

PAGE = (ROOT / "learners" / "THESIS.md").read_text("utf-8")


def shares(version, changes, figure):
    """A figure of the last evaluations of the trainings with these changes."""
    found = [each for each in study.measured() if (each.version, each.changes) == (version, changes)]
    assert len(found) == 2
    return [each.greedy[figure][-study.LAST :].mean() for each in found]


def test_the_page_has_the_table():
    table = PAGE.partition("small terminal rewards | seed")[2].partition("\n\n")[0]
    assert re.findall(r"^\|.*[^-|]\|$", table, re.MULTILINE)[-len(study.measured()) :] == study.results_table()


def test_both_changes_together_make_it_work_and_neither_alone():
    none, *one, both = [shares("mended", changes, "reached") for changes in ((), *zip(study.CHANGES), study.CHANGES)]
    assert min(both) > 0.5 > 0.2 > max(*none, *(share for each in one for share in each))
    assert max(shares("mended", study.CHANGES, "crashed")) == 0 < min(shares("mended", (), "crashed"))


def test_a_row_is_what_was_trained(tmp_path, monkeypatch):
    folder = tmp_path / "rewards-1-stuck-2" / "mended"
    folder.mkdir(parents=True)
    evaluation = {"episodes": 50, "coverage": 0.7, "t90": 390.0, "reached": 0.25, "crashed": 0.5, "stuck": 0.25}
    config = TrainingConfig(**MENDED, terminal_reward=10).model_dump()
    record = {"done": True, "seed": 7, "commit": "0123456789", "evaluations": [evaluation], "config": config}
    (folder / "training.json").write_text(json.dumps(record))
    (folder / "episodes.csv").write_text("score\n" + "\n".join(map(str, np.zeros(50))))
    monkeypatch.setattr(study, "MEASURED", tmp_path / "changes.csv")
    study.main([str(tmp_path)], study.MEASURED)
    (training,) = study.measured()
    assert (training.version, training.changes, training.seed) == ("mended", ("terminal_reward",), 7)
    assert training.greedy["stuck"].tolist() == [0.25]
    command = "indoor-explorers thesis --only rewards-1-stuck-2 --episodes 50 --versions mended --seed 7"
    assert f"{command} --set terminal_reward=10.0,0123456" in study.MEASURED.read_text()
