"""The report as a whole in a real browser: themes and sizes work, names do no harm."""

import re

import pytest

from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.report import write_report
from tests.evaluation.report.records import made_up, results_of, room

from .conftest import HOSTILE, opened

VALUES = "cells => cells.map((cell) => cell.value)"

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
    assert page.locator("#s1 table.results").get_by_text(HOSTILE).first.is_visible()
    assert "</script>" in page.locator("#replay-s1 select[aria-label=Episode]").inner_text()
    assert page.locator("img").count() == 0
    assert page.locator("#replay-s2 .panel").count() == 3


@pytest.mark.parametrize("width", [420, 800])
def test_a_narrow_screen_is_not_scrolled_sideways(page, width):
    page.set_viewport_size({"width": width, "height": 800})
    page.wait_for_function("width => document.documentElement.scrollWidth <= width", arg=width)
    for place in page.locator("#replay-s1 .panel, #replay-s1 .timeline, #replay-s1 button.play").all():
        box = place.bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= width
    page.set_viewport_size({"width": 1280, "height": 900})


@pytest.mark.parametrize("number", [1, 2, 3])
def test_the_league_of_a_few_scenarios_fits_a_window_of_1300(browser, tmp_path, number):
    rooms = [room(f"{name}-with-a-long-name") for name in ("obstacles", "floors", "team")[:number]]
    lates = {"frontier-predictive-learned": 20.0, "frontier-nearest": 31.0, "reaches-it-now-and-then": 60.0}
    records = [
        made_up(name, Task(each.name, 0, seed), None if late == 60.0 and seed < place else late + seed % 5)
        for place, each in enumerate(rooms, 2)
        for name, late in lates.items()
        for seed in range(12)
    ]
    results = results_of(records, *rooms)
    results.policies["frontier-predictive-learned"]["uses_generator"] = True  # a wide badge
    write_report(results, tmp_path / "report.html")
    with opened(browser, (tmp_path / "report.html").as_uri(), viewport={"width": 1300, "height": 900}) as visited:
        table = visited.page.locator(".scroll:has(> .league)")
        assert table.locator("svg.dot-plot").count() == len(lates) * number
        assert table.evaluate("box => box.scrollWidth <= box.clientWidth")


def test_print_leaves_the_controls_out_and_folds_again(page):
    page.emulate_media(media="print")
    assert not page.locator("#replay-s1 .transport").is_visible()
    assert not page.locator("nav").is_visible()
    assert page.locator("#replay-s1 canvas.map").first.is_visible()
    page.emulate_media(media="screen")
    folded = "document.querySelectorAll('details:not([open])').length"
    before = page.evaluate(folded)
    assert page.pdf()[:4] == b"%PDF"
    assert page.evaluate(folded) == before > 0


def test_less_motion_where_it_is_asked_for(page):
    page.emulate_media(reduced_motion="reduce")
    assert page.evaluate("getComputedStyle(document.documentElement).scrollBehavior") == "auto"
    page.emulate_media(reduced_motion="no-preference")


def test_a_narrow_screen_has_one_panel_a_picker_and_controls_in_reach(visit):
    with visit(viewport={"width": 420, "height": 800}, reduced_motion="reduce") as opened:
        page = opened.page
        assert page.locator("#replay-s1 .panel").count() == 1
        room = page.locator("#replay-s1 .panels").bounding_box()
        assert page.locator("#replay-s1 .panel canvas.map").bounding_box()["width"] >= room["width"] - 4
        page.locator("#replay-s1 .panel select").select_option(label="raises")
        assert page.locator("#replay-s1 .panel").get_attribute("data-policy") == "raises"
        page.locator("#replay-s1").evaluate("box => box.scrollIntoView()")
        play = page.locator("#replay-s1 button.play").bounding_box()
        assert play["y"] + play["height"] <= 800
        assert page.locator(".scroll.cut + .cue").first.is_visible()
        assert opened.complaints == []


def test_a_click_on_a_heading_sorts(page):
    table = page.locator("#s1 table.results")
    head = table.locator("thead th").nth(1)

    def order():
        return [float(value) for value in table.locator("tbody td:nth-of-type(1) data").evaluate_all(VALUES)]

    head.click()
    rising = order()
    assert rising == sorted(rising)
    assert head.get_attribute("aria-sort") == "ascending"
    head.click()
    assert order() == sorted(rising, reverse=True)
    assert table.locator("thead th").first.evaluate("head => getComputedStyle(head).position") == "sticky"


def test_secondary_figures_are_folded_until_they_are_opened(page):
    folds = page.locator("#s1 details.fold:has(table.duels), #s1 details.fold:has(table.rank-plot)")
    assert folds.count() == 2
    assert [fold.evaluate("fold => fold.open") for fold in folds.all()] == [False, False]
    folds.first.locator("summary").click()
    assert folds.first.locator("table").is_visible()
    folds.first.locator("summary").click()
    profile = page.locator("#s1 details.fold:has(.plot)")
    profile.locator("summary").click()
    page.wait_for_timeout(300)
    assert profile.locator(".plot svg").first.bounding_box()["width"] > 300
    profile.locator("summary").click()
