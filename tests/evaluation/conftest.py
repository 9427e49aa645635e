"""Comparisons in these tests draw no figures for print and check no plug-ins, which would take most of their time."""

import pytest

from indoor_explorers.evaluation import driver, exports
from indoor_explorers.evaluation.exports.figures import write_figures
from indoor_explorers.evaluation.harness.engines.plugin_checks import found_in_flights, with_failed_checks
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report.page import render
from tests.evaluation.reports import HOSTILE, Page, Wander, results_of, task_on


@pytest.fixture(scope="package", autouse=True)
def _short():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(exports, "write_figures", lambda *_: [])
        patch.setattr(driver, "with_failed_checks", lambda experiment, about, stored, loader: dict(about))
        patch.setattr(driver, "found_in_flights", lambda experiment, store, memory_limit: {})
        yield


@pytest.fixture
def figures(monkeypatch):
    """Have comparisons draw the figures in a test that takes this argument."""
    monkeypatch.setattr(exports, "write_figures", write_figures)


@pytest.fixture
def checks(monkeypatch):
    """Have comparisons check plug-ins for hidden knowledge in a test that takes this argument."""
    monkeypatch.setattr(driver, "with_failed_checks", with_failed_checks)
    monkeypatch.setattr(driver, "found_in_flights", found_in_flights)


@pytest.fixture(scope="session")
def results() -> Results:
    policies = {"straight": Wander(sweep=0.95), "wavy": Wander(sweep=0.6), "broken": Wander(breaks=True)}
    found = results_of(policies, [task_on(), task_on(4, "four", **{"radio.model": "unlimited"})], 6)
    found.policies["wavy"]["privileged"] = True
    return found


@pytest.fixture(scope="session")
def hostile() -> Results:
    policies = {name: Wander(sweep=sweep) for name, sweep in zip(HOSTILE, (0.95, 0.8, 0.3), strict=True)}
    return results_of(policies, [task_on(name="</script><img src=x onerror=alert(2)> 🏢")], 3)


@pytest.fixture(scope="session")
def page(results: Results) -> Page:
    return Page(render(results))
