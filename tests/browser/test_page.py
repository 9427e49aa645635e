"""The report as a whole in a real browser: themes and sizes work, names do no harm."""

import re

import pytest

from .conftest import HOSTILE

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("browser")]


def test_light_and_dark(page):
    def paper():
        return page.evaluate("getComputedStyle(document.body).backgroundColor")

    light = paper()
    page.locator("#theme").click()
    dark = paper()
    assert sum(map(int, re.findall(r"\d+", dark)[:3])) < 150 < sum(map(int, re.findall(r"\d+", light)[:3]))
    page.locator("#theme").click()
    assert paper() == light


def test_names_are_shown_as_they_are(page):
    assert page.locator("#s1 table").first.get_by_text(HOSTILE).first.is_visible()
    assert "</script>" in page.locator("#replay-s1 select[aria-label=Episode]").inner_text()
    assert page.locator("img").count() == 0
    assert page.locator("#replay-s2 .panel").count() == 3


@pytest.mark.parametrize("width", [420, 800])
def test_a_narrow_screen_is_not_scrolled_sideways(page, width):
    page.set_viewport_size({"width": width, "height": 800})
    page.wait_for_timeout(300)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    for place in page.locator("#replay-s1 .panel, #replay-s1 .timeline, #replay-s1 button.play").all():
        box = place.bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= width
    page.set_viewport_size({"width": 1280, "height": 900})


def test_print_leaves_the_controls_out(page):
    page.emulate_media(media="print")
    assert not page.locator("#replay-s1 .transport").is_visible()
    assert not page.locator("nav").is_visible()
    assert page.locator("#replay-s1 canvas.map").first.is_visible()
    page.emulate_media(media="screen")
    assert page.pdf()[:4] == b"%PDF"


def test_less_motion_where_it_is_asked_for(page):
    page.emulate_media(reduced_motion="reduce")
    assert page.evaluate("getComputedStyle(document.documentElement).scrollBehavior") == "auto"
    page.emulate_media(reduced_motion="no-preference")
