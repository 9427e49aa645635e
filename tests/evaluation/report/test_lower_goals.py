"""Results of scenarios that ask for less than 99 % coverage: compared by the threshold that they ask for."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from indoor_explorers.env import Scenario
from indoor_explorers.evaluation.analysis.comparability import verdict_on
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.headline import headline
from indoor_explorers.evaluation.analysis.panels.sweep_plots import range_plots
from indoor_explorers.evaluation.analysis.panels.team_scaling import scaling_plots
from indoor_explorers.evaluation.analysis.shown_best import shown_best
from indoor_explorers.evaluation.analysis.sweeps import radio_sweeps, team_scalings
from indoor_explorers.evaluation.analysis.tables.headline_table import headline_table
from indoor_explorers.evaluation.analysis.tables.league_table import league_table
from indoor_explorers.evaluation.analysis.tables.results_table import columns_of, results_table
from indoor_explorers.evaluation.analysis.task_times import TaskTimes
from indoor_explorers.evaluation.drawing.palette import policy_styles
from indoor_explorers.evaluation.exports.markdown import markdown_tables
from indoor_explorers.evaluation.exports.scenario_tables import caption, scenario_tables
from indoor_explorers.evaluation.exports.tidy import write_episodes
from indoor_explorers.evaluation.harness.episodes.record import Outcome, Record
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.ratios import Ratios
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report.charts.interactive import times_data
from indoor_explorers.evaluation.report.page import render
from indoor_explorers.evaluation.report.replay.selection import notable_tasks
from indoor_explorers.evaluation.report.summary.overview import lead
from indoor_explorers.evaluation.statistics import contrasts
from tests.evaluation.report.records import BUDGET, made_up, results_of, room
from tests.evaluation.reports import Page

TIMES: Mapping[str, Sequence[float | None]] = {
    "slow": [30, 41, 52, 63, 74, 85, None],
    "quick": [20, 31, 41, 53, 62, 75, 70],
    "knows": [10, 15, 20, 25, 30, 35, 40],
}
NEAR, FAR = room("near", goal=0.9), room("far", goal=1.0)


def _record(policy: str, scenario: Scenario, seed: int, late: float | None) -> Record:
    """Return an episode that gets to its goal after ``late`` steps and has no time above it."""
    beyond = {key: None for key in ("t95", "t98", "t99") if scenario.goal < 0.99}
    record = made_up(policy, Task(scenario.name, 0, seed), late, team=scenario.team, **beyond)
    return replace(record, outcome=Outcome.BUDGET if late is None else Outcome.COMPLETE)


def _results(*scenarios: Scenario) -> Results:
    records = [
        _record(policy, each, seed, late)
        for each in scenarios
        for policy, times in TIMES.items()
        for seed, late in enumerate(times)
    ]
    return results_of(records, *scenarios, privileged=["knows"])


@pytest.fixture(scope="module")
def near() -> Results:
    return _results(NEAR)


@pytest.fixture(scope="module")
def mixed() -> Results:
    return _results(NEAR, FAR)


def _times(policy: str) -> np.ndarray:
    return np.array([BUDGET if late is None else late for late in TIMES[policy]], float)


def _printed(results: Results, width: int) -> str:
    console = Console(width=width, file=io.StringIO(), record=True)
    console.print(headline_table(results, width))
    return console.export_text()


def _section(text: str, number: int) -> str:
    """Return what a reader sees of the section of one scenario."""
    (found,) = re.findall(rf'<section id="s{number}" class="scenario">.*?</section>', text, flags=re.S)
    return " ".join(Page(found).text.replace("\u202f", " ").split())


def test_ranking_contrasts_and_headline_are_of_the_level_asked_for(near: Results) -> None:
    comparison = Comparison(near, "near")
    assert comparison.ranking == ["quick", "slow", "knows"]
    times = {name: _times(name) for name in ("quick", "slow")}
    reached = {name: near.reached("near", name, "t90") for name in times}
    by_hand = contrasts(times, "quick", maps=near.maps("near", "quick"), reached=reached, margin=0.05, chosen=True)
    assert comparison.contrasts["slow"] == by_hand["slow"]
    both = reached["slow"] & reached["quick"]
    assert comparison.differences("slow").tolist() == (_times("slow") - _times("quick"))[both].tolist()
    text = headline(comparison)
    assert "<b>quick</b> reached 90 % coverage first on average: mean T90 50.3" in text
    assert "<b>knows</b>, which is given the true map, took 25.0 steps" in text


def test_a_headline_without_rivals_or_success_names_the_level(near: Results) -> None:
    alone = [record for record in near.records if record.policy == "quick"]
    told = headline(Comparison(replace(near, records=alone), "near"))
    assert "reached 90 % coverage after 50.3" in told
    assert "no other policy" in told
    never = [replace(r, metrics=r.metrics | {"t90": None}) for r in alone]
    assert "No policy reached 90 % coverage" in headline(Comparison(replace(near, records=never), "near"))


def test_a_policy_that_failed_a_check_is_named_and_not_ranked(near: Results) -> None:
    policies = near.policies | {"quick": near.policies["quick"] | {"failed_check": "map of the seed: knows it"}}
    comparison = Comparison(replace(near, policies=policies), "near")
    assert comparison.ranked_policies == ["slow"]
    text = headline(comparison)
    assert text.startswith("<b>slow</b> reached 90 % coverage after")
    assert "<b>quick</b>, which failed a check and is not ranked, took 50.3 steps" in text


def test_no_text_of_the_page_is_about_a_level_that_was_not_asked_for(near: Results) -> None:
    text = render(near)
    shown = _section(text, 1)
    assert "99 %" not in shown
    assert "T90 against quick" in shown
    assert "T90 by seed" in shown
    assert "steps to 90 % coverage" in shown
    assert shown.count("T99") == 1  # the column of dashes
    page = Page(text)
    assert "99\u202f%" not in page.text
    assert "one policy's T90 minus the other's" in page.text
    assert page.figures["quick", "t90"][0] == pytest.approx(_times("quick").mean())
    assert ("quick", "t99") not in page.figures
    assert any(note.startswith("Episodes that never reached 90 % count") for note in verdict_on(near).notes)


def test_a_table_has_a_dash_for_what_was_not_asked_for(near: Results) -> None:
    comparison, styles = Comparison(near, "near"), policy_styles(near.policies)
    keys = [column.key for column in columns_of(comparison.level)]
    assert keys[:4] == ["t90", "t90_reached", "t99", "t90_dots"]
    cells = next(row.cells for row in results_table(comparison, styles) if row.name == "quick")
    assert [(cells[k].text, cells[k].best) for k in (0, 2)] == [("50.3", True), ("\u2013", False)]
    assert [column.title for column in columns_of(Comparison(_results(FAR), "far").level)][:5] == [
        *("T90", "reached 90\u202f%", "T99", "reached 99\u202f%", "T99 by episode")
    ]


def test_charts_panels_and_replays_are_of_the_level(near: Results) -> None:
    comparison, styles = Comparison(near, "near"), policy_styles(near.policies)
    times = times_data(comparison, styles)
    assert [level["key"] for level in times["levels"]] == ["t90"]
    assert times["focus"] == int(75 * 1.05) + 1  # of those that mostly get there, which slow does not
    task_times = TaskTimes.of(comparison)
    assert task_times.times[:, task_times.policies.index("slow")].tolist() == _times("slow").tolist()
    picks = {pick.label: pick.task.seed for pick in notable_tasks(comparison)}
    assert (picks["fastest"], picks["slowest"]) == (0, 6)


def test_sweeps_show_the_times_that_were_asked_for() -> None:
    deaf = room("deaf", 2, goal=0.9)
    heard = room("heard", 2, goal=0.9, **{"radio.model": "unlimited"})
    results = _results(NEAR, deaf, heard)
    styles = policy_styles(results.policies)
    (sweep,) = radio_sweeps(results.scenarios)
    assert [plot.title for plot in range_plots(results, sweep, styles)][:2] == ["T90 [steps]", "AUC"]
    scaling = team_scalings(results.scenarios)[0]
    assert [plot.title for plot in scaling_plots(results, scaling, styles)] == [
        "Speed-up to 90 %",
        "Efficiency to 90 %",
    ]


def test_the_terminal_takes_the_level_that_all_share(near: Results, mixed: Results) -> None:
    alone = _printed(near, 170)
    assert "90 % reached" in alone
    assert "99 %" not in alone
    assert "T90 / knows" in alone
    assert f"{(_times('quick') / _times('knows')).mean():.2f} [" in alone
    both = _printed(mixed, 170)
    assert "near (T90)" in both
    assert "far (T99)" in both
    assert "steps / knows" in both
    quick = [row for row in both.splitlines() if row.strip().startswith("quick")]
    assert [("\u2013" in row) for row in quick] == [True, False]


def test_scenarios_of_several_levels_are_told_apart(mixed: Results) -> None:
    comparisons = {f"s{number}": Comparison(mixed, name) for number, name in enumerate(mixed.scenarios, 1)}
    league = league_table(comparisons, policy_styles(mixed.policies))
    assert ([column.unit[:3] for column in league.columns], league.first) == (["T90", "T99"], "quick")
    near, far = dict(league.rows)["quick"]
    assert near is not None
    assert far is not None
    assert near.text == far.text
    assert "Lowest mean time to the coverage threshold: <b>quick</b> in 2" in lead(
        [Comparison(mixed, name) for name in mixed.scenarios]
    )
    text = render(mixed)
    assert "99 %" not in _section(text, 1)
    assert "quick reached 99 % coverage first" in _section(text, 2)
    assert any("never reached the threshold of their scenario" in note for note in verdict_on(mixed).notes)
    assert "one policy's steps to the threshold of the scenario minus" in Page(text).text


def test_ratios_to_a_policy_that_knows_the_map_are_empty_where_99_was_not_asked_for(
    mixed: Results, tmp_path: Path
) -> None:
    assert np.isnan(mixed.values("near", "quick", "t99_to_reference")).all()
    expected = (_times("quick") / _times("knows")).tolist()
    assert mixed.values("far", "quick", "t99_to_reference").tolist() == expected
    assert mixed.to_reference("near", "quick", "t90").tolist() == expected
    write_episodes(mixed, tmp_path / "results.csv")
    with (tmp_path / "results.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["scenario"]: bool(row["t99_to_reference"]) for row in rows} == {"near": False, "far": True}
    assert {row.metric for row in Ratios.of(_results(NEAR)).rows} == {"t90"}


def test_tables_for_papers_are_of_the_level(near: Results) -> None:
    text, comparison = markdown_tables(scenario_tables(near)), Comparison(near, "near")
    assert "| policy | T90 [steps] | T99 [steps] | 90 % reached |" in text
    assert re.search(r"\| quick \| \**50\.3\** \[.*?\] \| \u2013 \| 100\u202f% \[.*?\]\u202f% \|", text)
    assert "T90 is the first step with 90 % coverage" in " ".join(caption(comparison))
    assert shown_best(comparison, "t90") == ["quick"]


def test_the_summary_keeps_its_rows(near: Results) -> None:
    rows = near.summary().query("policy == 'quick'").set_index("metric")
    assert rows.loc["t99", "mean"] == BUDGET
    assert rows.loc["t99", "success"] == 0
    assert rows.loc["t90", "mean"] == pytest.approx(_times("quick").mean())
