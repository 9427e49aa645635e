"""The coverage chart in a real browser: it tells figures, hides and shows policies, and opens replays."""

import re

import pytest

from .conftest import HOSTILE, PLAIN

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("browser")]


def lines(page, chart="chart-s1"):
    """Return the visibility of each policy's mean curve."""
    return page.evaluate(
        """chart => Object.fromEntries(document.getElementById(chart).data
             .filter((trace) => trace.meta !== undefined)
             .map((trace) => [trace.meta, trace.visible ?? true]))""",
        chart,
    )


def plot(page, chart="chart-s1"):
    area = page.locator(f"#{chart} .nsewdrag").first
    area.scroll_into_view_if_needed()
    return area.bounding_box()


def test_hovering_a_curve_tells_its_figures(page):
    box = plot(page)
    page.mouse.move(box["x"] + box["width"] / 3, box["y"] + box["height"] / 2)
    page.mouse.move(box["x"] + box["width"] / 3 + 2, box["y"] + box["height"] / 2, steps=3)
    tip = page.locator("#chart-s1 .hoverlayer .legend")
    tip.wait_for()
    told = tip.text_content()
    assert re.search(r"step \d+", told)
    assert len(re.findall(r"\d+\.\d %", told)) >= 3
    assert "<script>" in told
    page.mouse.move(5, 5)


def test_a_policy_is_hidden_and_shown_alone(page):
    legend = page.locator("#s1 .legend").first
    button = legend.locator("button", has_text=PLAIN)
    button.click()
    assert lines(page)[PLAIN] is not True
    assert lines(page)[HOSTILE] is True
    page.wait_for_timeout(400)
    button.click()
    assert set(lines(page).values()) == {True}
    page.wait_for_timeout(400)
    button.dblclick()
    assert {name for name, visible in lines(page).items() if visible is True} == {PLAIN}
    legend.locator("button.all").click()
    assert set(lines(page).values()) == {True}


def test_the_coverage_of_the_team_or_of_the_worst_uav_is_chosen(page):
    curve = "() => [...document.getElementById('chart-s1').data.find((trace) => trace.meta === 'wander').y]"
    team = page.evaluate(curve)
    page.locator("#s1").get_by_role("button", name="Worst UAV").first.click()
    worst = page.evaluate(curve)
    assert worst != team
    assert all(low <= high for low, high in zip(worst, team, strict=True))
    page.locator("#s1").get_by_role("button", name="Team", exact=True).first.click()
    assert page.evaluate(curve) == team


def test_a_click_on_a_curve_opens_the_replay_there(page):
    box = plot(page)
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 4, steps=2)
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 4)
    page.wait_for_function("() => location.hash.startsWith('#replay=s1')")
    page.wait_for_function("() => document.activeElement.id === 'replay-s1'")
    middle = page.evaluate("() => document.getElementById('chart-s1').layout.xaxis.range[1] / 2")
    assert abs(int(page.locator("#replay-s1 [role=slider]").get_attribute("aria-valuenow")) - middle) < 4


def test_no_chart_offers_to_share_itself(page):
    titles = page.locator(".modebar-btn").evaluate_all("all => all.map((button) => button.dataset.title)")
    assert any(title.startswith("Download") for title in titles)
    assert not [title for title in titles if re.search(r"share|cloud|studio|upload", title, re.IGNORECASE)]
    charts = page.locator(".js-plotly-plot").evaluate_all("all => all.map((box) => box._context)")
    assert {(each["showSendToCloud"], each["plotlyServerURL"]) for each in charts} == {(False, "")}
