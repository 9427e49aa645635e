"""Ratios of steps: the numbers by plain computation, what enters, and where they are written."""

from __future__ import annotations

import csv
import io
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.analysis.tables.ratio_table import ratio_lines, ratio_tables
from indoor_explorers.evaluation.exports.markdown import markdown_ratios
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.experiment.selection import chosen_baselines
from indoor_explorers.evaluation.harness.results.ratios import POOLED, Ratios, write_ratios
from indoor_explorers.evaluation.report.page import render
from tests.evaluation.report.records import BUDGET, made_up, results_of, room
from tests.evaluation.reports import Page

TIMES = {
    "frontier-nearest": {"near": [20, 40, 10, 50, 30, 25], "far": [80, 60, 100, 90, 70, 85]},
    "quick": {"near": [10, 30, 10, 25, 20, 20], "far": [60, 50, 75, 80, 70, 60]},
    "late": {"near": [40, None, 10, 60, 30, 90], "far": [None, 90, None, 95, 90, 99]},
    "knows": {"near": [10, 20, 5, 25, 15, 12], "far": [40, 30, 50, 45, 35, 40]},
}


@pytest.fixture
def results():
    records = [
        made_up(policy, Task(name, 0, seed), late)
        for policy, scenarios in TIMES.items()
        for name, times in scenarios.items()
        for seed, late in enumerate(times)
    ]
    return results_of(records, room("near"), room("far"), privileged=["knows"])


def steps(policy, scenario):
    return np.array([BUDGET if late is None else late for late in TIMES[policy][scenario]], float)


def rows(ratios):
    return {(row.scenario, row.policy, row.to, row.metric): row for row in ratios.rows}


def test_the_numbers_are_those_of_a_plain_computation(results):
    found = rows(Ratios.of(results))
    assert {to for _, _, to, _ in found} == {"frontier-nearest", "knows"}
    assert not any((POOLED, "late", to, "t99") in found for to in ("frontier-nearest", "knows"))
    for (scenario, policy, to, _), row in found.items():
        names = ["near", "far"] if scenario == POOLED else [scenario]
        ours, theirs = (np.concatenate([steps(each, name) for name in names]) for each in (policy, to))
        assert row.ratio.of_tasks.mean == pytest.approx((ours / theirs).mean())
        assert row.ratio.of_means.mean == pytest.approx(ours.mean() / theirs.mean())
        for estimate in row.ratio:
            assert estimate.low <= estimate.mean <= estimate.high
        assert (row.scenarios, row.tasks) == (len(names), 6 * len(names))


def test_only_tasks_that_all_flew_and_scenarios_that_a_policy_flew_enter(results):
    missing = [r for r in results.records if (r.policy, r.task) != ("late", ("near", 0, 1))]
    results.records[:] = [r for r in missing if (r.policy, r.task.scenario) != ("quick", "far")]
    found = rows(Ratios.of(results))
    kept = np.delete(np.arange(6), 1)
    row = found["near", "quick", "frontier-nearest", "t99"]
    assert row.tasks == 5
    assert row.ratio.of_tasks.mean == pytest.approx(
        (steps("quick", "near")[kept] / steps("frontier-nearest", "near")[kept]).mean()
    )
    assert ("far", "quick", "frontier-nearest", "t99") not in found
    assert (POOLED, "quick", "frontier-nearest", "t99") not in found
    assert found[POOLED, "late", "frontier-nearest", "t99"].tasks == 5


def test_a_level_that_nobody_was_asked_to_reach_is_left_out(results):
    results.scenarios["near"]["goal"] = 0.9
    found = {(row.scenario, row.metric) for row in Ratios.of(results).rows}
    assert found == {("near", "t90"), ("far", "t90"), (POOLED, "t90"), ("far", "t99")}


def test_a_level_that_was_there_at_the_start_counts_as_a_step(results):
    results.records[0].metrics["t99"] = 0
    found = rows(Ratios.of(results))["near", "quick", "frontier-nearest", "t99"].ratio.of_tasks.mean
    assert found == pytest.approx((10 / 1 + (steps("quick", "near") / steps("frontier-nearest", "near"))[1:].sum()) / 6)


def test_whom_policies_are_compared_with():
    assert chosen_baselines(["a", "frontier-nearest", "k"], ["k"]) == ["frontier-nearest", "k"]
    assert chosen_baselines(["k", "b", "c"], ["k"]) == ["b", "k"]
    assert chosen_baselines(["a", "b"], [], ["b", "a", "b"]) == ["b", "a"]
    with pytest.raises(InputError, match="got 'bb'; did you mean 'b'"):
        chosen_baselines(["a", "b"], [], ["bb"])


def test_tables_page_and_terminal_show_the_same_numbers(results, tmp_path):
    ratios = Ratios.of(results, ["frontier-nearest"])
    path = tmp_path / "ratios.csv"
    write_ratios(ratios, path)
    with path.open(newline="") as file:
        written = list(csv.DictReader(file))
    assert len(written) == (3 * 3 - 1) * 2
    table = next(each for each in ratio_tables(ratios) if each.key.startswith("t99"))
    assert [column.title for column in table.columns[1:]] == ["near", "far", POOLED]
    console = Console(width=120, record=True, file=io.StringIO())
    console.print(*ratio_lines(ratios))
    text, page = console.export_text(), Page(render(results, ratio_to=["frontier-nearest"]))
    for name, every, _ in table.rows:
        cells = [cell for cell in every if cell.text]
        mine = [row for row in written if (row["policy"], row["metric"]) == (name, "t99")]
        assert [cell.value for cell in cells] == pytest.approx([float(row["mean_of_ratios"]) for row in mine], rel=1e-5)
        assert page.figures[name, "t99_to_frontier-nearest"] == [cell.value for cell in cells]
        for cell in cells:
            assert cell.line in text
            assert f"| {cell.line} |" in markdown_ratios(ratios)
    shades = {name: [cell.shade for cell in cells if cell.text] for name, cells, _ in table.rows}
    assert all(shade > 0 for shade in shades["knows"])
    assert shades["late"][1] < 0


def test_a_policy_alone_has_nobody_to_be_compared_with():
    results = results_of([made_up("alone", Task("room", 0, seed), 10.0) for seed in range(6)])
    assert Ratios.of(results).rows == []
    assert markdown_ratios(Ratios.of(results)) == ""
    assert 'id="ratios"' not in render(results)


def of_policy(table, policy):
    """Return the cells of a policy."""
    return next(row.cells for row in table.rows if row.name == policy)


def censored(**times):
    """Return the ratios of one scenario with 40 tasks: T99 by policy, given from the first task on, then 20 steps."""
    records = [
        made_up(name, Task("room", 0, seed), found[seed] if seed < len(found) else 20.0)
        for name, found in {"frontier-nearest": [], **times}.items()
        for seed in range(40)
    ]
    return Ratios.of(results_of(records))


def test_a_ratio_of_steps_that_were_never_reached_is_a_bound(tmp_path):
    ratios = censored(late=[None] * 4, lost=[None] * 40)
    late, lost = (rows(ratios)["room", name, "frontier-nearest", "t99"] for name in ("late", "lost"))
    assert late.censoring == (40, 4, 0, 0)
    assert (late.censoring.bound, lost.censoring.bound) == (">", ">")
    cells = {name: cells[0] for name, cells, _ in ratio_tables(ratios)[0].rows}
    assert (cells["late"].text, cells["late"].detail) == ("> 1.400", "")
    assert cells["lost"].text == "> 5.000"
    for text in (markdown_ratios(ratios), Page(render(ratios.results)).text):
        assert "> 5.000" in text
        assert "bounds, as some episodes" in text
    write_ratios(ratios, tmp_path / "ratios.csv")
    with (tmp_path / "ratios.csv").open(newline="") as file:
        written = next(row for row in csv.DictReader(file) if (row["policy"], row["metric"]) == ("lost", "t99"))
    assert [written[name] for name in ("never_policy", "never_baseline", "never_both", "bound")] == [
        "40",
        "0",
        "0",
        ">",
    ]


def test_where_neither_reached_it_there_is_no_ratio():
    ratios = censored(**{"frontier-nearest": [None] * 40, "lost": [None] * 40, "sound": []})
    lost, sound = (rows(ratios)["room", name, "frontier-nearest", "t99"] for name in ("lost", "sound"))
    assert np.isnan(lost.ratio.of_tasks.mean)
    assert sound.censoring.bound == "<"
    assert of_policy(ratio_tables(ratios)[0], "lost")[0].text == "\N{EN DASH}"


def test_one_episode_in_forty_that_neither_reached_is_said_beside_the_figure():
    ratios = censored(**{"frontier-nearest": [None], "lost": [None]})
    (cell,) = of_policy(ratio_tables(ratios)[0], "lost")
    assert (cell.text, cell.value) == ("\N{ALMOST EQUAL TO} 1.000", 1.0)


def test_averages_over_scenarios_leave_out_what_the_budget_decides(results):
    table = next(each for each in ratio_tables(Ratios.of(results, ["frontier-nearest"])) if each.key.startswith("t99"))
    assert of_policy(table, "late")[2].text == ""
    in_time = [
        r.with_metrics(r.metrics | {"t99": 60}) if (r.policy, r.task.scenario) == ("late", "near") else r
        for r in results.records
    ]
    found = Ratios.of(replace(results, records=in_time), ["frontier-nearest"])
    cell = of_policy(next(each for each in ratio_tables(found) if each.key.startswith("t99")), "late")[2]
    assert cell.detail.endswith("1 of 2 scenarios")
    assert "leave out those" in markdown_ratios(found)
