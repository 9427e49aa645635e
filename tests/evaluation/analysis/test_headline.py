"""What stands above the tables claims no more than was flown and tested, whatever the order of the policies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from rich.console import Console

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.headline import headline
from indoor_explorers.evaluation.analysis.resolution import Outcomes, resolution
from indoor_explorers.evaluation.analysis.tables.headline_table import headline_table
from indoor_explorers.evaluation.harness.episodes.record import Outcome
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report.page import render
from indoor_explorers.evaluation.report.summary.overview import lead
from indoor_explorers.evaluation.statistics import Finding
from tests.evaluation.report.records import flown, made_up, results_of, room

NEVER: list[float | None] = [None] * 3


def of(scenarios: Mapping[str, Mapping[str, Sequence[float | None]]]) -> list[Comparison]:
    """Return comparisons from T99 by scenario and policy: one value a seed."""
    records = [
        made_up(policy, Task(scenario, 0, seed), late)
        for scenario, times in scenarios.items()
        for policy, values in times.items()
        for seed, late in enumerate(values)
    ]
    results = results_of(records, *(room(name) for name in scenarios))
    return [Comparison(results, name) for name in scenarios]


def both(times: Mapping[str, Sequence[float | None]]) -> list[Comparison]:
    """Return comparisons of two scenarios with the same times."""
    return of({"a": times, "b": times})


def test_a_scenario_counts_only_if_somebody_reached_the_level() -> None:
    for names in (["home", "joint", "near"], ["near", "joint", "home"]):
        tied: dict[str, list[float | None]] = {"home": [9, 20, 30], "joint": [9, 20, 30], "near": NEVER}
        told = lead(of({"a": dict.fromkeys(names, NEVER), "b": {name: tied[name] for name in names}}))
        assert told.startswith(
            "Lowest mean T99: <b>home</b> and <b>joint</b> in 1 of 2 scenarios; no policy reached 99 % in a. "
        )
    assert lead(both({"x": NEVER, "y": NEVER})) == "No policy reached 99 % in any of the 2 scenarios."


def test_all_that_share_the_lowest_mean_are_named() -> None:
    (told,) = map(headline, of({"a": {"c": [20] * 3, "b": [20] * 3, "d": [30] * 3, "a": [20] * 3}}))
    assert told.startswith("<b>a</b>, <b>b</b> and <b>c</b> share the lowest mean T99: 20.0 steps over 3 episodes")
    assert "<b>d</b> took +10.0 steps against" in told


def test_without_a_test_nothing_is_said_about_significance() -> None:
    few = both({"quick": [20, 21], "slow": [30, 31]})
    assert lead(few).endswith("Too few episodes for a test.")
    assert "significant" not in lead(few)


def test_the_first_line_says_what_was_resolved_and_what_was_not() -> None:
    quick = [20 + seed % 7 for seed in range(12)]
    times = {
        "quick": quick,
        "slow": [40 + each for each in quick],
        "level": [20 + seed % 5 for seed in range(12)][::-1],
    }
    two = both(times)
    assert lead(two).endswith("Significantly worse: slow in all. Not resolved: quick in all.")
    assert headline(two[0]).endswith("Significantly worse: slow. Not resolved: quick.")
    page = render(two[0].results)
    assert page.index("Significantly worse:") < page.index("flew the same") < page.index("<table")
    found: list[Outcomes] = [{Finding.OPEN: ["y"], Finding.WORSE: ["<i>"]}, {Finding.AS_GOOD: ["y"], None: ["<i>"]}]
    assert resolution(found, 0.025) == (
        "Significantly worse: &lt;i&gt; in 1. As good within 2.5\u202f%: y in 1. Not resolved: y in 1. "
        "Too few episodes for a test: &lt;i&gt; in 1."
    )


def test_who_never_finishes_is_worse_though_no_times_can_be_compared() -> None:
    times: dict[str, list[float | None]] = {"quick": [20.0 + seed % 7 for seed in range(12)], "never": [None] * 12}
    assert lead(both(times)).endswith("Significantly worse: never in all.")


def broken() -> Results:
    """Return results in which the second best has failed in every episode."""
    found = flown({"quick": [20, 21, 22], "slow": [95, 96, 97], "boom": NEVER})
    records = [
        replace(each, outcome=Outcome.FAILED, reason="ValueError: boom <b>") if each.policy == "boom" else each
        for each in found.records
    ]
    late = [replace(r, metrics=r.metrics | {"t99": 90.0}) if r.policy == "boom" else r for r in records]
    return replace(found, records=late)


def test_a_crash_is_not_told_as_slowness() -> None:
    results = broken()
    told = headline(Comparison(results, "room"))
    assert "<b>slow</b> took +75.0 steps" in told
    assert "<b>boom</b> failed in 3 of 3 episodes." in told
    page, console = render(results), Console(width=80)
    above = page[: page.index('id="caveats"')]
    assert '<span class="badge bad">failed 3 of 3</span>' in above
    assert "failed: boom in 3 of 3 episodes, first on room, seed 0, step 4: ValueError: boom &lt;b&gt;" in above
    assert "; failed in 3 of 3</td>" in page
    with console.capture() as capture:
        console.print(headline_table(results, 80))
    assert "boom (failed 3/3)" in capture.get()
