"""A page whose scenarios are in files beside it: they are loaded when asked for, from a folder too."""

import pytest

from indoor_explorers.evaluation.report import page as pages
from indoor_explorers.evaluation.report import write_report

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("browser")]


@pytest.fixture(scope="module")
def address(results, tmp_path_factory):
    path = tmp_path_factory.mktemp("parts") / "report.html"
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(pages, "WHOLE", 0)
        write_report(results, path)
    return path.as_uri()


def test_a_scenario_is_loaded_and_drawn_when_asked_for(page, shared):
    assert page.locator("#chart-s2").count() == 0
    assert not any(url.endswith(".js") for url in shared.asked)
    page.locator("[data-load=s2]").click()
    page.locator("#chart-s2 .js-plotly-plot, #chart-s2.js-plotly-plot").wait_for()
    page.locator("#replay-s2 canvas").first.wait_for()
    assert page.locator("#s1[data-part]").count() == 1
    shared.asked[:] = [url for url in shared.asked if "report_files/part-s2-" not in url]


def test_addresses_lead_into_files(visit):
    for hash_, there in (("#s2", "#chart-s2.js-plotly-plot"), ("#replay=s1;step=3", "#replay-s1 canvas")):
        with visit(hash_) as opened:
            opened.page.locator(there).first.wait_for()
            assert opened.complaints == []


def test_a_missing_file_is_named(visit):
    with visit() as opened:
        opened.page.evaluate("document.getElementById('s1').dataset.part = 'lost.js'")
        opened.page.locator("[data-load=s1]").click()
        opened.page.get_by_text("cannot be read; keep it beside this page").wait_for()
