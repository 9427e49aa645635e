"""Documents show every picture that is drawn for them, in order, and each is an SVG file."""

import re
from xml.etree import ElementTree

import pytest

from indoor_explorers.evaluation.site.pictures import clusters, sensor_errors
from indoor_explorers.evaluation.site.pictures.dynamics import dynamics_pictures
from indoor_explorers.evaluation.site.pictures.learners import learner_pictures
from indoor_explorers.evaluation.site.pictures.maps import map_pictures
from indoor_explorers.evaluation.site.pictures.planners import planner_pictures
from indoor_explorers.evaluation.site.pictures.radio import radio_pictures
from indoor_explorers.evaluation.site.pictures.statistics import statistics_pictures
from indoor_explorers.evaluation.site.pictures.tabular import page_functions, tabular_pictures
from indoor_explorers.evaluation.site.pictures.thesis import thesis_pictures
from indoor_explorers.evaluation.site.pictures.thesis_changes import thesis_changes_pictures
from tests.documents import ROOT

PAGES = "evaluation/site/pages"


@pytest.fixture
def shorter(monkeypatch):
    """Flights and trainings of fewer steps."""
    monkeypatch.setattr(clusters, "SEEDS", range(100, 102))
    monkeypatch.setattr(sensor_errors, "STEPS", 40)
    monkeypatch.setitem(page_functions(), "EPISODES", 60)
    monkeypatch.setitem(page_functions(), "TESTS", [0])


@pytest.mark.parametrize(
    ("draw", "start", "documents"),
    [
        (dynamics_pictures, "dynamics-", [f"{PAGES}/guides/dynamics.md"]),
        pytest.param(
            learner_pictures,
            "learner-",
            [f"learners/{name}.md" for name in ("DDDQN", "places/PLACES", "pockets/POCKETS")],
            marks=pytest.mark.slow,
        ),
        (map_pictures, "maps-", [f"{PAGES}/scenarios.md"]),
        pytest.param(planner_pictures, "planner-", ["planners/PLANNERS.md"], marks=pytest.mark.slow),
        (radio_pictures, "radio-", [f"{PAGES}/methods-radio.md"]),
        (sensor_errors.sensor_error_pictures, "errors-", [f"{PAGES}/harder-tasks.md"]),
        pytest.param(statistics_pictures, "statistics-", ["evaluation/STATISTICS.md"], marks=pytest.mark.slow),
        pytest.param(tabular_pictures, "tabular-", [f"{PAGES}/guides/tabular.md"], marks=pytest.mark.slow),
        (thesis_changes_pictures, "changed-", ["learners/THESIS.md"]),
        pytest.param(thesis_pictures, "thesis-", ["learners/THESIS.md"], marks=pytest.mark.slow),
    ],
)
def test_documents_show_every_picture_in_order(draw, start, documents, shorter):
    pictures = draw()
    text = "".join((ROOT / document).read_text("utf-8") for document in documents)
    assert re.findall(rf"gallery/({start}[\w-]+\.svg)", text) == list(pictures)
    for picture in pictures.values():
        assert ElementTree.fromstring(picture).tag.endswith("svg")
        assert len(picture) > 10_000
