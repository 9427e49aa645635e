"""A report with awkward names, and a real browser that shows it."""

from contextlib import contextmanager
from dataclasses import replace
from types import SimpleNamespace

import pytest

from indoor_explorers.env import PRESETS
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report import write_report
from indoor_explorers.evaluation.site.studies.report_tour import BROWSERS, chromium
from tests.evaluation.plugins import Raises, Wander

#: Nothing is fetched in the background; a container's root may run it.
SWITCHES = [
    *("--disable-gpu", "--no-first-run", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync"),
]
#: WebGL without a graphics card.
SOFTWARE_GL = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
PLAIN = "wander"
HOSTILE = 'a, b; "quoted" it\'s 50% </script><script>window.broken = 1</script> 🚁 $x_1$ & <b>'


class Elsewhere(Wander):
    """Fly at random, other ways than the one that it is made from."""

    def pilot(self, briefing):
        briefing.rng.random()
        return super().pilot(briefing)


#: The last flies as the first does.
NAMES = {PLAIN: Wander(), HOSTILE: Elsewhere(), "raises": Raises(), "copy": Wander(speed=2)}
MAP = "</script><img src=x onerror='window.broken = 2'> 🏢"
LOSSY = {"radio.model": "disc", "radio.range": 5.0, "radio.loss": 0.4, "budget": 120}


@pytest.fixture(scope="session")
def results():
    """Four policies on a team task with flaky radio, 6 seeds, and on a single UAV's task with hostile names."""
    team = PRESETS["thesis-team-4"].for_evaluation().with_settings(LOSSY)
    alone = PRESETS["thesis-open"].for_evaluation().with_settings({"budget": 60, "name": "alone </script> 🏠"})
    records = []
    for scenario, seeds in ((team, 6), (alone, 2)):
        tasks = [Task(scenario.name, 0, seed) for seed in range(seeds)]
        for name, policy in NAMES.items():
            flown = fly(policy, name, scenario, tasks)
            records += [replace(each, floorplan=replace(each.floorplan, name=MAP)) for each in flown]
    about = {"use": "wander", "class": "tests:Wander", "privileged": False, "parameters": {}}
    return results_from(records, (team, alone), {name: dict(about) for name in NAMES})


@pytest.fixture(scope="session")
def address(results, tmp_path_factory):
    """Where the report is."""
    path = tmp_path_factory.mktemp("report") / "report.html"
    write_report(results, path)
    return path.as_uri()


@pytest.fixture(scope="module")
def driver():
    """What starts browsers."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright drives the browser and is not installed")
    with playwright.sync_playwright() as driver:
        yield driver


@pytest.fixture(scope="module")
def browser(driver):
    """A headless browser with a profile of its own, without WebGL."""
    with launched(driver, *SWITCHES, "--disable-3d-apis") as running:
        yield running


@pytest.fixture(scope="module")
def drawing_browser(driver):
    """A headless browser that draws WebGL in software."""
    with launched(driver, *SWITCHES[1:], *SOFTWARE_GL) as running:
        yield running


@contextmanager
def launched(driver, *switches):
    """Start the browser that is found; the test is skipped where there is none."""
    found = chromium()
    if found is None:
        pytest.skip(f"expected a Chromium on the PATH ({', '.join(BROWSERS)}), found none; make browser installs one")
    running = driver.chromium.launch(executable_path=found, args=list(switches), chromium_sandbox=False)
    yield running
    running.close()


@contextmanager
def opened(browser, address, **looks):
    """Open an address; yield the page, what it complains about, and what it asks for."""
    options = {"viewport": {"width": 1280, "height": 900}, "color_scheme": "light", **looks}
    page = browser.new_context(**options).new_page()
    page.set_default_timeout(20_000)
    complaints, asked = [], []
    page.on("console", lambda message: complaints.append(message.text) if message.type != "log" else None)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    page.goto(address)
    yield SimpleNamespace(page=page, complaints=complaints, asked=asked)
    page.context.close()


@pytest.fixture(scope="module")
def visit(browser, address):
    """Open the report at a hash."""
    return lambda hash_="", **looks: opened(browser, address + hash_, **looks)


def results_from(records, scenarios, about):
    """Return the results of flights, of policies that ``about`` describes by name."""
    settings = {each.name: {"fingerprint": each.fingerprint, **each.model_dump(mode="json")} for each in scenarios}
    return Results(about, settings, [], records)


@pytest.fixture(scope="module")
def shared(visit):
    """One open page that most tests use, each leaving it usable."""
    with visit() as opened:
        yield opened


@pytest.fixture
def page(shared, address):
    """The shared page; after the test it must have nothing to complain of, and have asked for no other file."""
    yield shared.page
    assert shared.complaints == []
    assert {url.partition("#")[0] for url in shared.asked if not url.startswith(("data:", "blob:"))} == {address}
    assert shared.page.evaluate("window.broken") is None


@pytest.fixture(scope="session")
def record_of(results):
    """Find a record by scenario number from 1, policy and seed."""

    def find(section, policy, seed):
        name = list(results.scenarios)[section - 1]
        return next(r for r in results.groups[name, policy] if r.task.seed == seed)

    return find
