"""Differences of steps to a baseline: the numbers by plain computation, what enters, and where they are written."""

from __future__ import annotations

import csv
import io

import numpy as np
import pytest
from rich.console import Console

from indoor_explorers.evaluation.analysis.tables.difference_table import difference_lines
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.differences import differences, write_differences
from tests.evaluation.report.records import BUDGET, made_up, results_of, room

TIMES = {
    "base": [40, 50, 60, 55, 45, 52, 48, 61],
    "quick": [30, 41, 50, 44, 36, 40, 39, 50],
    "late": [42, None, 58, 57, 44, 52, 50, 60],
    "knows": [20, 25, 30, 25, 20, 25, 25, 30],
}


@pytest.fixture
def results():
    records = [
        made_up(policy, Task("near", 0, seed), late)
        for policy, times in TIMES.items()
        for seed, late in enumerate(times)
    ]
    return results_of(records, room("near"), privileged=["knows"])


def test_differences_are_paired_and_what_knows_the_map_is_a_family_of_its_own(results):
    found = {(row.policy, row.metric): row.contrast for row in differences(results, ["base"])}
    assert {metric for _, metric in found} == {"t90", "t99", "auc"}
    steps = {name: np.array([BUDGET if late is None else late for late in times]) for name, times in TIMES.items()}
    for name in ("quick", "late", "knows"):
        contrast, both = found[name, "t99"], steps[name] < BUDGET
        assert contrast.difference.mean == pytest.approx((steps[name] - steps["base"])[both].mean())
        assert (contrast.pairs, contrast.both) == (8, both.sum())
        tested = {"quick": 3, "late": 2, "knows": 1}[name]  # the means of two policies, and the success of one
        assert contrast.adjusted_p == pytest.approx(min(1.0, contrast.p_value * tested))
    assert [found[name, "t99"].shown for name in ("quick", "late", "knows")] == [True, False, True]
    assert found["late", "t99"].tally.losses > 0


def test_only_common_tasks_enter(results):
    results.records[:] = [r for r in results.records if (r.policy, r.task.seed) != ("late", 1)]
    found = {(row.policy, row.metric): row.contrast for row in differences(results, ["base"])}
    assert found["quick", "t99"].pairs == 7
    assert differences(results, ["nobody"]) == []


def test_terminal_and_table_show_the_same_numbers(results, tmp_path):
    rows = differences(results, ["base", "late"])
    write_differences(rows, tmp_path / "differences.csv")
    with (tmp_path / "differences.csv").open(newline="") as file:
        written = {(row["policy"], row["minus"], row["metric"]): row for row in csv.DictReader(file)}
    assert len(written) == 2 * 3 * 3
    row = written["quick", "base", "t99"]
    assert list(row)[-7:-5] == ["significant", "both_finished"]
    assert (row["margin"], row["finding"], written["late", "base", "t99"]["both_finished"]) == ("0.05", "better", "7")
    assert written["quick", "base", "auc"]["equivalence_p"] == ""
    assert (row["tasks"], row["better"], row["significant"]) == ("8", "8", "True")
    console = Console(width=120, record=True, file=io.StringIO())
    console.print(*difference_lines(results, rows))
    shown = [float(row[key]) for key in ("difference", "low", "high")]
    assert (
        "\N{MINUS SIGN}{:.1f} [\N{MINUS SIGN}{:.1f}, \N{MINUS SIGN}{:.1f}] *".format(*map(abs, shown))
        in console.export_text()
    )
