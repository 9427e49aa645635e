from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.headline import headline
from indoor_explorers.evaluation.analysis.tables.contrast_table import contrast_table
from indoor_explorers.evaluation.analysis.tables.results_table import (
    columns_of,
    constant_columns,
    measures_table,
    results_table,
)
from indoor_explorers.evaluation.drawing.palette import policy_styles
from indoor_explorers.evaluation.harness.episodes.metrics import WASTED
from indoor_explorers.evaluation.harness.episodes.record import Outcome, Record
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.coverage_threshold import T99
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report.page import render
from indoor_explorers.evaluation.statistics import contrasts
from tests.evaluation.report.records import made_up, results_of
from tests.evaluation.reports import Page


def test_figures_of_the_table_are_those_of_the_summary(results: Results, page: Page) -> None:
    summary, styles = results.summary(), policy_styles(results.policies)
    hidden = {
        name: {column.key for column, _ in constant_columns(columns_of(T99), results_table(comparison, styles))}
        for name in results.scenarios
        for comparison in [Comparison(results, name)]
    }
    assert {"collisions", "overlap", "messages_bytes"} <= hidden["rooms"]
    assert not {"overlap", "messages_bytes"} & hidden["four"]
    for metric in ("t90", "t99", "auc", "path_length", "overlap", "collisions", "messages_bytes", "latency_p99_us"):
        for policy in results.policies:
            rows = summary[(summary.policy == policy) & (summary.metric == metric)]
            means = [mean for name, mean in zip(rows.scenario, rows["mean"], strict=True) if metric not in hidden[name]]
            assert page.figures.get((policy, metric), []) == pytest.approx(means)
    assert page.figures["broken", "failures"] == [6, 6]


def _with_t99(results: Results, policy: str, shift: Sequence[int]) -> Results:
    """Return a copy in which a policy's T99 is that of ``straight`` shifted."""
    straight = {r.task: r.metrics["t99"] or 100.0 for r in results.records if r.policy == "straight"}
    records = []
    for record in results.records:
        late = straight[record.task] + (shift[record.task.seed] if record.policy == policy else 0)
        records.append(replace(record, outcome=Outcome.COMPLETE, metrics=record.metrics | {"t99": late}))
    return Results(results.policies, results.scenarios, results.runs, records)


@pytest.mark.parametrize(
    ("shift", "words"),
    [
        ([9, 10, 11, 9, 10, 11], "the difference is significant"),
        ([-9, 10, -11, 9, -8, 12], "the difference is not significant (adjusted p"),
        ([0] * 6, "share the lowest mean T99"),
    ],
)
def test_a_headline_claims_only_what_was_shown(results: Results, shift: list[int], words: str) -> None:
    two = Results(
        {name: results.policies[name] for name in ("straight", "broken")},
        results.scenarios,
        [],
        [record for record in results.records if record.policy != "wavy"],
    )
    assert words in headline(Comparison(_with_t99(two, "broken", shift), "rooms"))


def test_maps_get_a_table_of_their_own(results: Results) -> None:
    records = [
        replace(r, task=r.task._replace(map_index=r.task.seed % 2), floorplan=replace(r.floorplan, name=f"house-{k}"))
        for r in results.records
        for k in [r.task.seed % 2]
    ]
    text = Page(render(Results(results.policies, results.scenarios, results.runs, records))).text
    assert "T99 by map" in text
    assert "house-1" in text


def test_contrasts_are_those_of_the_tasks_flown_by_all(results: Results) -> None:
    comparison = Comparison(results, "rooms")
    ours = {name: results.values("rooms", name, "t99") for name in ("straight", "broken")}
    reached = {name: results.reached("rooms", name, "t99") for name in ours}
    by_hand = contrasts(ours, comparison.ranked_policies[0], reached=reached, chosen=True)
    rows = {row.policy: row for row in contrast_table(comparison, policy_styles(results.policies))}
    assert list(rows) == [*comparison.ranked_policies[1:], "wavy"]
    other = comparison.ranked_policies[1]
    assert rows[other].difference.value is None  # no task was finished by both
    assert by_hand[other].both == len(comparison.differences(other)) == 0
    assert sum(rows[other].tally) == 6
    assert comparison.contrasts[other].adjusted_p == by_hand[other].adjusted_p


def test_a_table_of_contrasts_says_what_it_could_have_shown(results: Results) -> None:
    noisy = Comparison(_with_t99(results, "broken", [-9, 10, -11, 9, -8, 12]), "rooms")
    (row,) = (row for row in contrast_table(noisy, policy_styles(results.policies)) if row.policy == "broken")
    found = noisy.contrasts["broken"]
    assert row.verdict == f"not resolved (about {found.needed:.0f} tasks would)"
    assert math.isfinite(found.detectable)
    without = Comparison(replace(noisy.results, margin=0.0), "rooms")
    (row,) = (row for row in contrast_table(without, policy_styles(results.policies)) if row.policy == "broken")
    assert row.verdict == f"not significant (detectable: {found.detectable:.1f} steps)"
    clear = Comparison(_with_t99(results, "broken", [9, 10, 11, 9, 10, 11]), "rooms")
    assert {row.policy: row.verdict for row in contrast_table(clear, policy_styles(results.policies))}[
        "broken"
    ] == "slower"


def test_without_common_tasks_nothing_is_contrasted(results: Results) -> None:
    sound = [replace(r, outcome=Outcome.BUDGET) for r in results.records]
    odd = [r for r in sound if (r.task.seed % 2 == 0) == (r.policy == "straight")]
    comparison = Comparison(replace(results, records=odd), "rooms")
    assert comparison.contrasts == {}
    assert "cannot be tested" in headline(comparison)


def test_every_measure_is_somewhere_on_the_page(results: Results, page: Page) -> None:
    rows = {column.key: cells for column, cells in measures_table(Comparison(results, "four"))}
    assert {"auc_worst", "auc_mean", "age_of_information", "balance", "t99_to_bound", "t99_to_reference"} <= rows.keys()
    worst = [float(np.mean(results.values("four", name, "auc_worst"))) for name in results.policies]
    assert [cell.value for cell in rows["auc_worst"]] == pytest.approx(worst)
    shown = {about.get("data-measure") for tag, about in page.tags if tag == "tr"}
    assert rows.keys() <= shown


def test_few_maps_cannot_show_a_difference_and_the_table_says_so(results: Results) -> None:
    plans = [r.floorplan for r in results.groups["rooms", "straight"]]
    records = [
        replace(r, task=r.task._replace(map_index=m, seed=r.task.seed), floorplan=plans[m])
        for r in _with_t99(results, "broken", [9, 10, 11, 9, 10, 11]).records
        if r.task.scenario == "rooms"
        for m in range(5)
    ]
    comparison = Comparison(Results(results.policies, results.scenarios, [], records), "rooms")
    assert comparison.over_maps
    assert comparison.contrasts["broken"].maps == 5
    rows = {row.policy: row for row in contrast_table(comparison, policy_styles(results.policies))}
    assert rows["broken"].verdict == "not resolved (about 6 maps would)"


def test_who_freezes_stands_out_and_older_results_that_did_not_measure_it_load() -> None:
    def policy(name: str, idle: float | None) -> list[Record]:
        return [made_up(name, Task("room", 0, seed), 9.0, longest_idle=idle if seed == 1 else 1.0) for seed in range(3)]

    older = [made_up("older", Task("room", 0, seed), 9.0) for seed in range(3)]
    older = [replace(r, metrics={k: v for k, v in r.metrics.items() if k not in WASTED}) for r in older]
    found = results_of([*policy("frozen", 40.0), *policy("fine", 3.0), *older])
    cells = {row.name: row.cells for row in results_table(Comparison(found, "room"), policy_styles(found.policies))}
    place = [column.key for column in columns_of(T99)].index("longest_idle")
    frozen, fine, missing = (cells[name][place] for name in ("frozen", "fine", "older"))
    assert (frozen.text, frozen.detail, frozen.bad) == ("14.0", "\u2264 40", True)
    assert (fine.text, fine.bad) == ("1.7", False)
    assert (missing.value, missing.bad) == (None, False)
    assert 'class="bad"' in render(found)
    assert set(found.summary().query("policy == 'older'")["metric"]) & set(WASTED) == set()


def test_columns_that_are_the_same_for_all_are_named_below_instead() -> None:
    def policy(name: str, late: float, idle: float) -> list[Record]:
        tasks = [Task("room", 0, seed) for seed in range(6)]
        none: dict[str, float | None] = {"collisions": 0.0, "messages_bytes": 0.0, "longest_idle": idle}
        records = [made_up(name, task, late + task.seed, overlap=late / 100) for task in tasks]
        return [replace(record, metrics=record.metrics | none) for record in records]

    found = results_of([*policy("quick", 10, 0), *policy("slow", 20, 0)])
    columns = columns_of(T99)
    rows = results_table(Comparison(found, "room"), policy_styles(found.policies))
    hidden = {column.key: cell.text for column, cell in constant_columns(columns, rows)}
    assert {"collisions": "0", "messages_bytes": "0", "longest_idle": "0.0", "failures": "0"}.items() <= hidden.items()
    assert hidden["t99_reached"] == "100\u202f%"
    assert not {"t90", "t99", "t99_dots", "overlap"} & hidden.keys()
    text = Page(render(found)).text
    assert "The same for all: reached 90" in text
    assert "collisions 0" in text
    assert Page(render(found)).figures["", "collisions"] == [0.0]


def test_a_constant_column_that_is_bad_and_that_of_a_single_policy_stay() -> None:
    frozen = [made_up(name, Task("room", 0, seed), 9.0, longest_idle=40.0) for name in "ab" for seed in range(6)]
    for found in (results_of(frozen), results_of(frozen[:6])):
        rows = results_table(Comparison(found, "room"), policy_styles(found.policies))
        assert "longest_idle" not in {column.key for column, _ in constant_columns(columns_of(T99), rows)}
