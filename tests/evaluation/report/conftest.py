from __future__ import annotations

import pytest

from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report.page import render

from .reports import HOSTILE, Page, Wander, results_of, task_on


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
