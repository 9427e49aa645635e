"""The replay viewer in a real browser: it shows what was recorded, and can be led to any moment."""

import json
from urllib.parse import quote, unquote

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, make_policy
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.report import write_report

from .conftest import HOSTILE, PLAIN, opened, results_from

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("browser")]

REPLAY = "#replay-s1"


def open_replay(page, **asked):
    page.evaluate("asked => openReplay('s1', asked)", asked)


def shown(page):
    """Return what the panels read, by policy."""
    return {
        panel.get_attribute("data-policy"): panel.locator(".readout").inner_text()
        for panel in page.locator(f"{REPLAY} .panel").all()
    }


def map_of(page, section="s1"):
    return page.locator(f"#replay-{section} select[aria-label='Map of']")


def step(page, which="now"):
    return int(page.locator(f"{REPLAY} [role=slider]").get_attribute(f"aria-value{which}"))


def last_step(page):
    return step(page, "max")


def data(page):
    return json.loads(page.locator("#replay-data-s1").text_content())


def pictures(page):
    return page.evaluate(f"[...document.querySelectorAll('{REPLAY} canvas.map')].map((map) => map.toDataURL())")


def settled(page, part):
    """Wait for the address to hold something: it follows a moment after the replay."""
    page.wait_for_function("part => location.hash.includes(part)", arg=part)
    return page.evaluate("location.hash")


@pytest.mark.parametrize("chosen", [0, 1, 4])
def test_readouts_are_those_of_the_record_at_every_step(page, record_of, chosen):
    episode = data(page)["episodes"][0]
    seed = episode["task"][1]
    records = {name: record_of(1, name, seed) for name in (PLAIN, HOSTILE, "raises")}
    open_replay(page, task=[0, seed])
    map_of(page).select_option(str(chosen - 1) if chosen else "team")
    for now in (0, 1, 2, 5, 17, 44, last_step(page)):
        open_replay(page, task=[0, seed], step=now)
        assert step(page) == now
        texts = shown(page)
        for name, record in records.items():
            there = min(now, record.steps)
            covered = record.covered[there, chosen] / record.reachable
            assert f"{100 * covered:.1f} %" in texts[name]
            assert f"step {there} " in texts[name]
            assert f"{record.distance[there]} cells flown" in texts[name]
            assert ("flying" in texts[name]) == (there < record.steps)
    map_of(page).select_option("team")
    assert "policy failed" in shown(page)["raises"]


def test_dragging_the_timeline_scrubs(page):
    open_replay(page, step=0)
    slider = page.locator(f"{REPLAY} [role=slider]")
    slider.scroll_into_view_if_needed()
    box = slider.bounding_box()
    page.mouse.move(box["x"] + 60, box["y"] + 50)
    page.mouse.down()
    early = step(page)
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + 50, steps=3)
    half = step(page)
    page.mouse.move(box["x"] + 3 * box["width"], box["y"] + 50)
    page.mouse.up()
    assert 0 < early < half < step(page) == last_step(page)
    assert abs(half - last_step(page) / 2) < 4


def test_it_plays_and_pauses_and_keys_step(page):
    open_replay(page, step=3)
    page.keyboard.press("ArrowRight")
    assert step(page) == 4
    page.keyboard.press("Shift+ArrowRight")
    assert step(page) == 14
    page.keyboard.press("Home")
    page.keyboard.press("Space")
    page.wait_for_function(f"() => document.querySelector('{REPLAY} [role=slider]').getAttribute('aria-valuenow') > 3")
    page.locator(f"{REPLAY} button.play").click()
    assert page.locator(f"{REPLAY} button.play").inner_text() == "Play"
    rests = step(page)
    page.wait_for_timeout(250)
    assert step(page) == rests > 3
    page.locator(f"{REPLAY} select[aria-label=Speed]").focus()
    page.keyboard.press("Home")
    assert step(page) == rests
    page.get_by_label("One step back").first.click()
    assert step(page) == rests - 1


def test_layers_change_the_picture_and_back(page):
    open_replay(page, step=9)
    for name in ("truth", "known", "frontier", "lidar", "trails"):
        before = pictures(page)
        page.locator(f"{REPLAY} input[name={name}]").uncheck()
        assert all(one != other for one, other in zip(before, pictures(page), strict=True)), name
        page.locator(f"{REPLAY} input[name={name}]").check()
        assert pictures(page) == before


def test_a_uav_alone_knows_no_more_than_the_team(page):
    open_replay(page, step=25)
    team = pictures(page)
    choice = map_of(page)
    assert choice.locator("option").all_inner_texts() == ["team", "UAV 0", "UAV 1", "UAV 2", "UAV 3"]
    choice.select_option("3")
    assert "map=uav-3" in settled(page, "map=uav-3")
    assert pictures(page) != team
    choice.select_option("team")
    assert pictures(page) == team


def test_panels_are_chosen_and_swapped(page):
    open_replay(page, step=5)
    page.locator(f"{REPLAY} .choice button", has_text="2").click()
    names = list(shown(page))
    assert len(names) == 2
    page.locator(f"{REPLAY} .panel select").first.select_option(label=names[1])
    assert list(shown(page)) == names[::-1]
    (absent,) = {PLAIN, HOSTILE, "raises"} - set(names)
    open_replay(page, policy=absent)
    assert absent in shown(page)
    page.locator(f"{REPLAY} .choice button", has_text="3").click()
    assert set(shown(page)) == {PLAIN, HOSTILE, "raises"}


def test_an_episode_that_is_not_there_is_told_with_the_way_to_have_it(page):
    said = page.locator(f"{REPLAY} .said")
    open_replay(page, task=[0, 4711], policy="nobody")
    assert "seed 4711" in said.inner_text()
    assert "--replays 6" in said.inner_text()
    assert "nobody" in said.inner_text()
    open_replay(page, task=data(page)["episodes"][0]["task"])
    assert said.inner_text() == ""


def test_elements_of_a_section_open_its_replay(page):
    last = len(data(page)["episodes"]) - 1
    task = data(page)["episodes"][last]["task"]
    page.evaluate(
        """asked => { for (const tag of ["button", "td"]) {
             const made = document.createElement(tag);
             made.dataset.replay = asked; made.tabIndex = 0; made.id = "opens-" + tag; made.textContent = "open";
             document.querySelector("#s1 h2").after(made);
           } }""",
        json.dumps({"policy": HOSTILE, "task": task, "step": 2}),
    )
    for act in (lambda: page.locator("#opens-button").click(), lambda: page.locator("#opens-td").press("Enter")):
        open_replay(page, step=11)
        act()
        assert step(page) == 2
        assert page.locator(f"{REPLAY} select[aria-label=Episode]").input_value() == str(last)
    page.evaluate("for (const made of document.querySelectorAll('[id^=opens-]')) made.remove()")


def test_the_address_names_the_moment_and_leads_back_to_it(page, visit):
    task = data(page)["episodes"][1]["task"]
    open_replay(page, task=task, step=7, policy=HOSTILE)
    page.locator(f"{REPLAY} input[name=lidar]").uncheck()
    map_of(page).select_option("2")
    page.get_by_text("Copy link").first.click()
    hash_ = settled(page, "map=uav-2")
    page.locator(f"{REPLAY} input[name=lidar]").check()
    map_of(page).select_option("team")
    assert f"task={task[0]},{task[1]};step=7;" in hash_
    assert HOSTILE in unquote(hash_)
    with visit(hash_ + ";dark;nonsense;more=%E0%A4%A") as again:
        assert step(again.page) == 7
        assert map_of(again.page).input_value() == "2"
        assert not again.page.locator(f"{REPLAY} input[name=lidar]").is_checked()
        assert again.page.locator("html").get_attribute("data-theme") == "dark"
        assert 0 <= again.page.locator(REPLAY).bounding_box()["y"] < 200
        again.page.evaluate(f"location.hash = '#replay=s1;step=1;panels={quote(PLAIN)},unknown;map=9'")
        again.page.wait_for_function("() => document.querySelectorAll('#replay-s1 .panel').length === 1")
        assert list(shown(again.page)) == [PLAIN]
        assert step(again.page) == 1
        again.page.evaluate("location.hash = '#replay=nowhere;task=,;step=x;panels=%;map=&layers'")
        assert again.complaints == []


def test_addresses_count_uavs_from_0_and_those_of_older_pages_from_1(page):
    chosen = map_of(page)
    for step_, (part, value) in enumerate(
        [("uav-0", "0"), ("uav-3", "3"), ("1", "0"), ("4", "3"), ("0", "team"), ("team", "team"), ("uav-9", "team")], 1
    ):
        page.evaluate(f"location.hash = '#replay=s1;step={step_};map={part}'")
        page.wait_for_function(f"() => document.querySelector('{REPLAY} [role=slider]').ariaValueNow === '{step_}'")
        assert chosen.input_value() == value, part


def test_it_opens_where_the_flights_differ_most(page, record_of):
    page.evaluate("location.hash = '#replay=s1'")
    page.wait_for_timeout(400)
    place = data(page)["episodes"][0]["task"][1]
    curves = [record_of(1, name, place).covered[:, 0] for name in (PLAIN, HOSTILE, "raises")]
    last = max(map(len, curves))
    apart = np.ptp([np.pad(each, (0, last - len(each)), "edge") for each in curves], axis=0)
    open_replay(page, task=[0, place])
    assert last_step(page) == last - 1
    assert step(page) == apart.argmax()


def test_same_flights_share_a_panel_and_can_be_chosen_all_the_same(page):
    open_replay(page, task=[0, data(page)["episodes"][0]["task"][1]], step=4)
    page.locator(f"{REPLAY} .choice button").last.click()
    assert set(shown(page)) == {PLAIN, HOSTILE, "raises"}
    assert page.locator(f"{REPLAY} .panel[data-policy={PLAIN}] .twins").inner_text() == "same flights: copy"
    page.evaluate("location.hash = '#replay=s1;step=4;panels=copy,wander'")
    page.wait_for_function(f"() => document.querySelectorAll('{REPLAY} .panel').length === 2")
    assert list(shown(page)) == ["copy", PLAIN]
    one, other = pictures(page)
    assert one == other


def test_unknown_cells_at_full_coverage_are_explained(browser, tmp_path):
    scenario = PRESETS["thesis-obstacles"].for_evaluation().with_settings({"goal": 1.0})
    records = list(fly(make_policy("frontier-nearest"), "one", scenario, [Task(scenario.name, 0, 4)]))
    write_report(results_from(records, [scenario], {"one": {}}), tmp_path / "report.html")
    with opened(browser, (tmp_path / "report.html").as_uri()) as shown_alone:
        page = shown_alone.page
        note = page.locator(f"{REPLAY} .pockets")
        page.get_by_label("To the start").click()
        assert not note.is_visible()
        page.get_by_label("To the end").click()
        assert "100.0 %" in page.locator(f"{REPLAY} .readout").inner_text()
        assert "cells that are still unknown are walls, or cannot be reached" in note.inner_text()


SHORT = {"radio.model": "disc", "radio.range": 4.0, "on_collision": "block", "budget": 80}
STOPS = {"failures.stops": [[1, 12], [3, 30]]}
HARDER = {
    "failures": STOPS,
    "base": {"base.at": "start"},
    "return": {"base.at": "start", "base.must_return": True, **STOPS},
    "prior": {"prior.kind": "outdated", "prior.furniture": 1.0},
    "errors": {"noise.misses": 0.1, "noise.false_returns": 0.02, "drift.rate": 0.05},
}


@pytest.fixture(scope="module")
def harder(browser, tmp_path_factory):
    """An open page with a scenario of each kind, and the records by section."""
    team = PRESETS["thesis-team-4"].for_evaluation()
    scenarios = [team.with_settings(SHORT | changes | {"name": name}) for name, changes in HARDER.items()]
    policy, path = make_policy("frontier-minpos"), tmp_path_factory.mktemp("harder") / "report.html"
    records = [record for each in scenarios for record in fly(policy, "one", each, [Task(each.name, 0, 4)])]
    write_report(results_from(records, scenarios, {"one": {}}), path)
    with opened(browser, path.as_uri()) as shown_harder:
        yield shown_harder.page, {f"s{place}": record for place, record in enumerate(records, 1)}
    assert shown_harder.complaints == []


@pytest.mark.parametrize("section", [f"s{place}" for place in range(1, 1 + len(HARDER))])
def test_readouts_are_those_of_the_record_where_tasks_are_harder(harder, section):
    page, records = harder
    record = records[section]
    read = page.locator(f"#replay-{section} .readout")
    lost = 0
    for step_ in range(record.steps + 1):
        page.evaluate("([section, step]) => openReplay(section, { step })", [section, step_])
        text = read.inner_text()
        assert text.startswith(f"{100 * record.curve[step_]:.1f} %"), step_
        if record.covered.shape[1] > 5:
            other, covered = ("team and base", "seen") if section == "s3" else ("at the base", "base")
            assert f"{other} {100 * record.coverage(covered)[step_]:.1f} %" in text
        lost += "of 4 stopped" in text
    assert (lost > 0) == (record.metrics.get("stopped", 0) > 0)


def test_the_map_of_the_base_is_shown_and_in_the_address(harder):
    page, records = harder
    for section, chosen in (("s2", "team"), ("s3", "base")):
        choice = map_of(page, section)
        assert choice.input_value() == chosen
        assert choice.locator("option").all_inner_texts()[:2] == ["team and base", "home base"]
    choice = map_of(page, "s2")
    choice.select_option("base")
    assert "map=base" in settled(page, "map=base")
    page.evaluate("openReplay('s2', { step: 20 })")
    base = records["s2"].coverage("base")[20]
    assert page.locator("#replay-s2 .readout b").inner_text() == f"{100 * base:.1f} %"
    choice.select_option("0")
    page.evaluate("location.hash = '#replay=s2;step=20;map=base'")
    page.wait_for_function("() => document.querySelector('#replay-s2 select[aria-label=\"Map of\"]').value === 'base'")


def test_the_prior_map_is_a_layer_where_there_is_one(harder):
    page, _ = harder
    assert page.locator("#replay-s1 input[name=prior]").count() == 0
    assert page.locator("#replay-s1 input[name=truth]").is_checked()
    prior, truth = (page.locator(f"#replay-s4 input[name={name}]") for name in ("prior", "truth"))
    assert prior.is_checked()
    assert truth.is_checked()
    picture = "document.querySelector('#replay-s4 canvas.map').toDataURL()"
    page.evaluate("openReplay('s4', { step: 0 })")
    seen = {page.evaluate(picture)}
    for box in (truth, prior, truth):
        box.click()
        seen.add(page.evaluate(picture))
    assert len(seen) == 4
