"""The picture of the report's tour: its numbers stand beside what the guide says, and the one that is kept is small."""

import io

import pytest
from PIL import Image

from indoor_explorers.evaluation.site.studies.report_tour import HEIGHT, READ, WIDTH, marked
from tests.documents import SITE

GUIDE, KEPT = SITE / "pages" / "guides" / "report.md", SITE / "pages" / "pictures" / "report-tour.png"


def test_the_guide_has_a_line_for_each_number_and_the_picture_is_small():
    tour = GUIDE.read_text("utf-8").partition("## A two-minute tour")[2].partition("\n## ")[0]
    assert [line[:3] for line in tour.splitlines() if line[:1].isdigit()] == [f"{k}. " for k in range(1, len(READ) + 1)]
    assert KEPT.stat().st_size < 150_000


@pytest.mark.slow
@pytest.mark.xdist_group("browser")
def test_every_number_is_drawn_in_the_picture(visit):
    with visit(viewport={"width": WIDTH, "height": HEIGHT}) as opened:
        picture = Image.open(io.BytesIO(marked(opened.page)))
        marks = opened.page.locator(".tour-mark")
        assert marks.all_inner_texts() == [str(k) for k in range(1, len(READ) + 1)]
        for box in (mark.bounding_box() for mark in marks.all()):
            assert 0 <= box["x"] < WIDTH - box["width"]
            assert box["y"] + box["height"] <= picture.height
    assert picture.width == WIDTH
