"""Why a UAV flies where it does, in a real browser: by click, tap, button, key and address."""

from urllib.parse import quote

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, make_policy
from indoor_explorers.env.policies.explanation import SILENT
from indoor_explorers.evaluation.harness.episodes.flight import explained_again
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Experiment, PolicyChoice, Task
from indoor_explorers.evaluation.harness.experiment.policy_facts import policy_facts
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report import write_report

from .conftest import opened

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("browser")]

SCENARIO = PRESETS["thesis-team-4"].for_evaluation()
POLICIES = ("frontier", "random")
WHY, ONE_PANEL = "#replay-s1 .why", "#replay=s1;step=7;panels=frontier"


@pytest.fixture(scope="module")
def record():
    return next(iter(fly(make_policy("frontier"), "frontier", SCENARIO, [Task(SCENARIO.name, 0, 4)])))


@pytest.fixture(scope="module")
def told(record):
    """What each UAV tells after each step."""
    return list(explained_again(record, SCENARIO, make_policy("frontier")))


@pytest.fixture(scope="module")
def explained(record, tmp_path_factory):
    """Where a report is whose flights are explained."""
    records = [record, *fly(make_policy("random"), "random", SCENARIO, [record.task])]
    settings = {SCENARIO.name: {"fingerprint": SCENARIO.fingerprint, **SCENARIO.model_dump(mode="json")}}
    choices = tuple(PolicyChoice(use=use, name=use) for use in POLICIES)
    experiment = Experiment(policies=choices, scenarios=(SCENARIO,), episodes=1, seed=4).to_toml()
    facts = {use: policy_facts(make_policy(use), use) for use in POLICIES}
    path = tmp_path_factory.mktemp("explained") / "report.html"
    write_report(Results(facts, settings, [], records, (experiment,)), path, explanations=60.0)
    return path.as_uri()


@pytest.fixture
def page(browser, explained):
    with opened(browser, explained + ONE_PANEL) as shown:
        yield shown.page
    assert shown.complaints == []


def spot(page, record, cell):
    """Where on the canvas a cell is, in CSS pixels."""
    box, (height, width) = page.locator("canvas.map").bounding_box(), record.floorplan.shape
    return {"x": (cell[1] + 0.5) * box["width"] / width, "y": (cell[0] + 0.5) * box["height"] / height}


def button_of(page, uav, policy="frontier"):
    return page.get_by_role("button", name=f"Explain where UAV {uav} of {policy} flies")


def picture(page):
    return page.evaluate("document.querySelector('#replay-s1 canvas.map').toDataURL()")


def seek(page, step):
    page.evaluate("step => openReplay('s1', { step })", step)


def test_a_click_explains_a_uav_and_another_one_stops(page, record):
    box, plain = page.locator(WHY), picture(page)
    assert not box.is_visible()
    where = spot(page, record, record.cells[7, 2])
    page.locator("canvas.map").click(position=where)
    assert "UAV 2 · step 7" in box.inner_text()
    assert button_of(page, 2).get_attribute("aria-pressed") == "true"
    marked = picture(page)
    assert marked != plain
    page.locator("canvas.map").click(position=where)
    assert not box.is_visible()
    assert picture(page) == plain


def test_a_click_beside_every_uav_explains_none(page, record):
    shape = record.floorplan.shape
    away = np.abs(np.indices(shape).reshape(2, -1, 1) - record.cells[7].T[:, None]).max(axis=0).min(axis=1)
    page.locator("canvas.map").click(position=spot(page, record, divmod(int(away.argmax()), shape[1])))
    assert not page.locator(WHY).is_visible()


def test_goal_way_and_candidates_are_what_the_pilot_tells_at_each_step(page, record, told):
    button_of(page, 1).click()
    rows = page.locator(f"{WHY} tbody tr")
    for step in (1, 2, 5, 9, 14, record.steps):
        seek(page, step)
        mine, said = told[step - 1][1], page.locator(WHY).inner_text()
        assert f"({mine.goal[0]}, {mine.goal[1]})" in said
        assert f"chosen at step {mine.step}" in said
        assert mine.score in said
        shown = [row.locator("td").all_inner_texts() for row in rows.all()]
        assert [cells[1] for cells in shown] == [f"({c.cell[0]}, {c.cell[1]})" for c in mine.candidates[:6]]
        for cells, candidate in zip(shown, mine.candidates, strict=False):
            values = [float(text.replace("\u2212", "-")) for text in cells[2:]]
            assert values == pytest.approx([candidate.score, *candidate.parts.values()], rel=0.006)
        left = [tuple(cell) for cell in mine.path]
        here = tuple(record.cells[step, 1].tolist())
        steps = len(left[left.index(here) :]) - 1 if here in left else len(left) - 1
        assert (f", {steps} step" in said) == (steps > 0)
    seek(page, 0)
    assert "It has not moved yet" in page.locator(WHY).inner_text()


def test_keys_are_enough(page):
    button_of(page, 3).focus()
    page.keyboard.press("Enter")
    assert "UAV 3 · step 7" in page.locator(WHY).inner_text()
    page.keyboard.press("ArrowRight")
    assert "UAV 3 · step 8" in page.locator(WHY).inner_text()
    page.keyboard.press("Escape")
    assert not page.locator(WHY).is_visible()
    page.keyboard.press("Space")
    assert page.locator(WHY).is_visible()
    page.get_by_role("button", name="Close the explanation").press("Enter")
    assert not page.locator(WHY).is_visible()


def test_the_explanation_is_named_for_those_who_hear_the_page(page):
    button_of(page, 0).click()
    assert page.get_by_role("region", name="Explanation").is_visible()
    assert page.get_by_role("group", name="Explain a UAV of frontier").get_by_role("button").count() == 4
    page.wait_for_function("() => document.querySelector('#replay-s1 .unseen').textContent.includes('UAV 0')")


def test_a_policy_that_tells_nothing_has_a_line_that_says_why(browser, explained):
    with opened(browser, explained + "#replay=s1;step=3;panels=random;why=random,1") as shown:
        said = shown.page.locator(WHY).inner_text()
        assert f"No explanation: {SILENT}." in said
        assert shown.page.locator(f"{WHY} tr").count() == 0 or not shown.page.locator(f"{WHY} table").is_visible()


def test_the_address_names_the_explained_uav_and_leads_back(page, browser, explained):
    button_of(page, 2).click()
    page.wait_for_function("() => location.hash.includes('why=frontier,2')")
    hash_ = page.evaluate("location.hash")
    with opened(browser, explained + hash_) as again:
        assert "UAV 2 · step 7" in again.page.locator(WHY).inner_text()
        for wrong in ("why=frontier,9", "why=nobody,0", "why=frontier,x", f"why={quote('a,b')}"):
            again.page.evaluate("hash => { location.hash = hash; }", f"{ONE_PANEL};{wrong}")
            again.page.wait_for_function("() => document.querySelector('#replay-s1 .why').hidden")
            again.page.evaluate("hash => { location.hash = hash; }", hash_)
            again.page.wait_for_function("() => !document.querySelector('#replay-s1 .why').hidden")
        assert again.complaints == []


def test_on_a_phone_a_tap_shows_it_above_the_controls_within_the_screen(browser, explained):
    looks = {"viewport": {"width": 360, "height": 780}, "is_mobile": True, "has_touch": True}
    with opened(browser, explained + ONE_PANEL, **looks) as shown:
        page = shown.page
        button_of(page, 1).tap()
        box = page.locator(WHY).bounding_box()
        deck = page.locator("#replay-s1 .deck").bounding_box()
        assert page.evaluate("document.documentElement.scrollWidth") == 360
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= 360
        assert box["y"] + box["height"] <= deck["y"] + 1
        for ask in page.locator("#replay-s1 .whys button").all():
            assert min(ask.bounding_box()["height"], ask.bounding_box()["width"]) >= 34
