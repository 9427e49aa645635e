"""Policies against the best planner of each scenario: which one that is, what is shown, and where it is written."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from indoor_explorers.evaluation.analysis.best_planner import (
    PlannerRow,
    against_best_planner,
    is_learner,
    read_best_planner,
    write_best_planner,
)
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.tables.planner_table import best_steps, planner_cell, planner_table
from indoor_explorers.evaluation.drawing.formatting import percent
from indoor_explorers.evaluation.drawing.print_style import print_style
from indoor_explorers.evaluation.exports import write_exports
from indoor_explorers.evaluation.exports.figures import write_figures
from indoor_explorers.evaluation.exports.figures.planner_figure import MOST, planner_figures
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report.page import render
from indoor_explorers.evaluation.statistics import Finding
from tests.evaluation.report.records import made_up, results_of, room

SEEDS = 12
NEAREST = np.arange(60, 60 + SEEDS, dtype=float)
WEIGHTS = {"weights_sha256": "0" * 64}


def results(times: Mapping[str, Mapping[str, Iterable[float | None]]], learners: Sequence[str]) -> Results:
    """Put results together from times by scenario and policy; ``map`` knows the map."""
    records = [
        made_up(policy, Task(scenario, 0, seed), late)
        for scenario, policies in times.items()
        for policy, values in policies.items()
        for seed, late in enumerate(values)
    ]
    found = results_of(records, *map(room, times), privileged=["map"])
    facts = {name: about | (WEIGHTS if name in learners else {}) for name, about in found.policies.items()}
    return replace(found, policies=facts)


def rows_of(found: Results) -> list[PlannerRow]:
    """Return the rows of all scenarios."""
    common = found.on_common_tasks
    return against_best_planner(Comparison(common, name) for name in common.scenarios)


@pytest.fixture(name="learned")
def _learned() -> Results:
    wave = np.where(np.arange(SEEDS) % 2, 3.0, -3.0)
    return results(
        {
            "small": {
                "nearest": NEAREST,
                "tree": NEAREST - 4,
                "network": NEAREST - 20,
                "twin": NEAREST - 4 + wave / 10,
                "map": NEAREST - 30,
            },
            "large": {
                "nearest": NEAREST,
                "tree": NEAREST + 24,
                "network": [None, *NEAREST[1:] + 20],
                "twin": NEAREST + 9 * wave,
                "map": NEAREST - 30,
            },
        },
        ["network", "twin"],
    )


def test_the_best_planner_is_the_fastest_policy_without_weights_that_is_ranked(learned: Results) -> None:
    small, large = rows_of(learned)
    assert (small.planner, large.planner) == ("tree", "nearest")
    assert {name for name, facts in learned.policies.items() if is_learner(facts)} == {"network", "twin"}
    found = {name: each.finding for name, each in small.policies.items()}
    assert found == {
        "tree": None,
        "nearest": Finding.WORSE,
        "network": Finding.BETTER,
        "twin": Finding.AS_GOOD,
        "map": Finding.BETTER,
    }
    assert small.policies["network"].row.ratio.of_tasks.mean == pytest.approx(np.mean((NEAREST - 20) / (NEAREST - 4)))
    assert small.policies["network"].row.metric == "t99"
    twin = large.policies["twin"]
    assert twin.finding is Finding.OPEN
    assert twin.needed > SEEDS
    assert large.best.reached == 1
    assert large.policies["network"].reached == pytest.approx(1 - 1 / SEEDS)
    assert large.best.steps == pytest.approx(NEAREST.mean())


def test_a_learner_without_its_network_is_a_planner() -> None:
    assert is_learner(WEIGHTS | {"parameters": {"network": "True"}})
    assert not is_learner(WEIGHTS | {"parameters": {"network": "False"}})
    assert not is_learner({"parameters": {"network": "True"}})


def test_its_file_holds_all_of_it(learned: Results, tmp_path: Path) -> None:
    found = rows_of(learned)
    write_best_planner(found, tmp_path / "best_planner.csv")
    again = read_best_planner(tmp_path / "best_planner.csv")
    assert [(row.title, row.planner, row.margin) for row in again] == [
        (row.policies[row.planner].row.scenario, row.planner, row.margin) for row in found
    ]
    for row, other in zip(found, again, strict=True):
        assert list(row.policies) == list(other.policies)
        for name in row.policies:
            assert planner_cell(row, name) == replace(planner_cell(other, name), value=planner_cell(row, name).value)
    write_best_planner(again, tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_bytes() == (tmp_path / "best_planner.csv").read_bytes()


def test_where_too_few_finish_for_a_ratio_the_share_that_did_is_told() -> None:
    half = [None if k % 2 else late for k, late in enumerate(NEAREST)]
    other = [late if k % 2 else None for k, late in enumerate(NEAREST)]
    times = {"nearest": half, "network": other}
    rows = rows_of(results({"small": times, "large": times}, ["network"]))
    assert planner_cell(rows[0], "network").line == f"{percent(0.5)} reached"
    assert best_steps(rows[0], 0) == "\N{GREATER-THAN OR EQUAL TO} 82 steps"
    table = planner_table(rows)
    assert table is not None
    assert table.rows[0].cells[0].line.endswith(f" 82.5 steps, {percent(0.5)} reached")


def test_it_needs_a_learner_a_planner_and_several_scenarios(learned: Results) -> None:
    assert not rows_of(replace(learned, policies={key: {} for key in learned.policies}))
    one = {name: settings for name, settings in learned.scenarios.items() if name == "small"}
    records = [record for record in learned.records if record.task.scenario == "small"]
    assert not rows_of(replace(learned, scenarios=one, records=records))
    two = {
        policy: [record for record in learned.records if record.policy == policy] for policy in ("nearest", "network")
    }
    later = [replace(each, task=each.task._replace(seed=each.task.seed + SEEDS)) for each in two["network"]]
    assert not rows_of(replace(learned, records=[*two["nearest"], *later]))  # no task in common
    assert len(rows_of(replace(learned, records=[*two["nearest"], *two["network"]]))) == 2
    networks = [record for record in learned.records if record.policy in ("network", "twin", "map")]
    assert not rows_of(replace(learned, records=networks))
    assert planner_table([]) is None


def test_its_table_has_learners_first_and_says_what_is_shown(learned: Results) -> None:
    table = planner_table(rows_of(learned))
    assert table is not None
    assert [column.title for column in table.columns[2:]] == ["network", "twin", "nearest", "tree", "map"]
    lines = {row.name: [cell.line for cell in row.cells] for row in table.rows}
    assert lines["small"][0] == "tree T99 61.5 steps"
    assert lines["small"][1].endswith("better")
    assert lines["small"][2].endswith("as good")
    assert lines["small"][4] == "1 best planner"
    assert lines["large"][1].startswith("> 1.")
    assert "not resolved (" in lines["large"][2]
    shades = [[cell.shade for cell in row.cells[1:]] for row in table.rows]
    assert shades == [[3, 0, -3, 0, 3], [-3, 0, 0, -3, 3]]


@pytest.mark.slow
def test_it_is_on_the_page_and_in_files(learned: Results, tmp_path: Path) -> None:
    assert '<section id="best-planner">' in render(learned, replays=0)
    write_exports(learned, tmp_path)
    found = rows_of(learned)
    rows = pd.read_csv(tmp_path / "tables" / "best_planner.csv")
    assert rows.groupby("scenario").to.unique().str[0].to_dict() == {"small": "tree", "large": "nearest"}
    assert set(rows[rows.shown == "better"].policy) == {"network", "map"}
    assert "## Steps as a ratio to the best planner" in (tmp_path / "tables" / "ratios.md").read_text()
    names = {path.name for path in write_figures(learned, tmp_path / "figures", found)}
    assert {f"best-planner-1.{ending}" for ending in ("svg", "png", "pdf")} <= names


def test_a_page_without_learners_has_no_such_section(learned: Results, tmp_path: Path) -> None:
    plain = replace(learned, policies={name: {} for name in learned.policies})
    assert "best-planner" not in render(plain, replays=0)
    write_exports(plain, tmp_path)
    assert not (tmp_path / "tables" / "best_planner.csv").exists()


def test_a_sheet_has_no_more_columns_than_fit(learned: Results) -> None:
    rows = rows_of(learned)
    many = [
        replace(row, policies={f"p{k}": row.policies["network"] for k in range(2 * MOST)} | {row.planner: row.best})
        for row in rows
    ]
    with print_style():
        sheets = planner_figures(many)
    assert [len(sheet.axes[0].get_xticks()) for sheet in sheets] == [MOST, MOST, 2]
    assert [tick.get_text() for tick in sheets[2].axes[0].get_xticklabels()] == ["tree", "nearest"]
    assert planner_figures([]) == []
