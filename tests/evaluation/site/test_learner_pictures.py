"""The pages on learners have their pictures, and the views that these show are what the pages say of them."""

import re

import numpy as np
import pytest

from indoor_explorers.evaluation.site.pictures import clusters as cluster_pictures
from indoor_explorers.evaluation.site.pictures.learners import learner_pictures, moment
from tests.documents import ROOT


def test_every_picture_of_the_pages_is_drawn(monkeypatch):
    monkeypatch.setattr(cluster_pictures, "SEEDS", range(100, 102))
    drawn = learner_pictures()
    pages = [path.read_text("utf-8") for path in (ROOT / "learners").rglob("*.md")]
    assert set(drawn) == set(re.findall(r"site/pages/gallery/(learner-[\w-]+\.svg)", " ".join(pages)))
    assert all(b"</svg>" in picture and len(picture) > 10_000 for picture in drawn.values())


def test_network_and_rule_choose_other_moves_in_the_view_that_is_shown():
    assert moment().q.argmax() != moment().rule.argmax()


def test_the_parts_of_the_values_add_up():
    q, advantage = moment().q, np.sum(moment().terms, axis=0)
    assert q - q.mean() == pytest.approx(advantage - advantage.mean(), abs=1e-5)


def test_network_and_planner_choose_other_places_in_the_view_that_is_shown():
    ours, planners = cluster_pictures.choice().goals
    assert ours != planners
