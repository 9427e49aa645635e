"""Ratios of steps: the numbers by plain computation, what enters, and where they are written."""

from __future__ import annotations

import csv
import io

import numpy as np
import pytest
from rich.console import Console

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.experiment.experiment import Task
from indoor_explorers.evaluation.experiment.selection import chosen_baselines
from indoor_explorers.evaluation.exports.markdown import markdown_ratios
from indoor_explorers.evaluation.report.page import render
from indoor_explorers.evaluation.report.tables.ratio_table import ratio_lines, ratio_tables
from indoor_explorers.evaluation.results.ratios import POOLED, Ratios, write_ratios
from tests.evaluation.report.records import BUDGET, made_up, results_of, room
from tests.evaluation.report.reports import Page

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
    assert found[POOLED, "late", "frontier-nearest", "t99"].tasks == 11


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
    assert len(written) == 3 * 2 * 3
    table = next(each for each in ratio_tables(ratios) if each.metric == "t99")
    assert [name for name, _ in table.scenarios] == ["near", "far", POOLED]
    console = Console(width=120, record=True, file=io.StringIO())
    console.print(*ratio_lines(ratios))
    text, page = console.export_text(), Page(render(results, ratio_to=["frontier-nearest"]))
    for name, cells in table.rows:
        mine = [row for row in written if (row["policy"], row["metric"]) == (name, "t99")]
        assert [cell.value for cell in cells] == pytest.approx([float(row["mean_of_ratios"]) for row in mine], rel=1e-5)
        assert page.figures[name, "t99_to_frontier-nearest"] == [cell.value for cell in cells]
        for cell in cells:
            assert f"{cell.text} {cell.interval}" in text
            assert f"| {cell.text} {cell.interval} |" in markdown_ratios(ratios)
    shades = {name: [cell.shade for cell in cells] for name, cells in table.rows}
    assert all(shade > 0 for shade in shades["knows"])
    assert shades["late"][2] < 0


def test_a_policy_alone_has_nobody_to_be_compared_with():
    results = results_of([made_up("alone", Task("room", 0, seed), 10.0) for seed in range(6)])
    assert Ratios.of(results).rows == []
    assert markdown_ratios(Ratios.of(results)) == ""
    assert 'id="ratios"' not in render(results)
