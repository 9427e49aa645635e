from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.panels.pareto_plot import pareto_plot, pareto_points
from indoor_explorers.evaluation.analysis.panels.performance_profile import profile_plot
from indoor_explorers.evaluation.analysis.panels.rank_plot import improvements, rank_rows
from indoor_explorers.evaluation.analysis.panels.scenario_panels import causes, scenario_panels
from indoor_explorers.evaluation.analysis.panels.times_by_map import times_table
from indoor_explorers.evaluation.analysis.panels.win_matrix import win_matrix
from indoor_explorers.evaluation.analysis.task_times import TaskTimes
from indoor_explorers.evaluation.drawing.formatting import EN_DASH
from indoor_explorers.evaluation.drawing.palette import policy_styles
from indoor_explorers.evaluation.harness.episodes.record import Outcome
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.results import Results
from tests.evaluation.report.records import flown, made_up, results_of

TIMES = {"quick": [10, 20, 30, None], "slow": [12, 20, 25, None]}


def compared(results: Results) -> tuple[Comparison, TaskTimes]:
    comparison = Comparison(results, "room")
    return comparison, TaskTimes.of(comparison)


def test_wins_ties_and_losses_are_counted_task_by_task() -> None:
    _, task_times = compared(flown(TIMES))
    cells = {name: row for name, row in win_matrix(task_times)}
    first, second = task_times.policies
    assert (first, second) == ("slow", "quick")
    duel = cells["quick"][0]
    assert duel.text == EN_DASH.join("121")
    assert duel.shade == 0
    assert json.loads(duel.replay) == {"policy": "quick", "task": [0, 0]}
    assert cells["quick"][1].text == ""


def test_a_policy_that_misses_tasks_is_compared_on_those_it_flew() -> None:
    whole = flown({"one": [10, 20, 30], "other": [11, 19, 31]})
    part = [record for record in whole.records if record.policy == "one" or record.task.seed > 0]
    comparison, task_times = compared(results_of(part))
    cells = {name: row for name, row in win_matrix(task_times)}
    duel = next(cell for cell in cells["one"] if cell.text)
    assert duel.text == EN_DASH.join("101")
    table = times_table(comparison, task_times)
    assert table is not None
    assert [name for name, _ in table.rows] == ["1", "2"]


def test_ranks_by_seed_mark_the_winner_and_the_missed() -> None:
    table = times_table(*compared(flown({"a": [10, 20, None, 50], "b": [20, 20, 90, 40]})))
    assert table is not None
    assert (table.unit, table.units) == ("seed", 4)
    assert table.policies == ["b", "a"]
    shown = [[(place.text, place.best, place.shade) for place in places] for _, places in table.rows]
    assert shown == [
        [("20", False, 4), ("10", True, 0)],
        [("20", False, 0), ("20", False, 0)],
        [("90", True, 0), ("never", False, 5)],
        [("40", True, 0), ("50", False, 2)],
    ]
    assert table.won == [(2, 0), (1, 0)]
    assert json.loads(table.rows[2][1][1].replay) == {"policy": "a", "task": [0, 2]}


def test_ranks_by_map_are_of_means_and_count_maps_won() -> None:
    results = flown({"a": [10, 20, 30, 40], "b": [12, 14, 50, None], "c": [30, 0, 60, 70]}, maps=[0, 0, 1, 1])
    table = times_table(*compared(results))
    assert table is not None
    assert table.unit == "map"
    assert table.policies == ["a", "c", "b"]
    (first, places), (second, others) = table.rows
    assert (first, second) == ("house-0", "house-1")
    assert [place.text for place in places] == ["15.0", "15.0", "13.0"]
    assert [place.best for place in places] == [False, False, True]
    assert [place.detail for place in others] == ["2/2", "2/2", "1/2"]
    assert table.won == [(1, 0), (0, 0), (1, 0)]


def test_shared_wins_are_told_apart() -> None:
    table = times_table(*compared(flown({"a": [10, 10], "b": [10, 20], "c": [30, 30]})))
    assert table is not None
    assert table.won == [(1, 1), (0, 1), (0, 0)]


def test_the_rank_plot_counts_ties_one_half() -> None:
    _, task_times = compared(flown(TIMES))
    found = improvements(task_times, [("quick", "slow")])["quick", "slow"]
    assert found is not None
    assert found.estimate == (0.5, None, None)
    assert found.scores.tolist() == [1, 0.5, 0, 0.5]
    assert found.reading == "too few tasks"


def test_the_rank_plot_compares_neighbours_and_the_best() -> None:
    times = {"c": [31, 29, 35, 30, 33, 32], "a": [10, 11, 12, 13, 14, 15], "b": [9, 12, 13, 14, 15, 16]}
    rows = rank_rows(compared(flown(times))[1])
    assert [row.policy for row in rows] == ["a", "b", "c"]
    assert rows[0].best is None
    assert rows[-1].next is None
    first, second = rows[0].next, rows[1].next
    assert first is not None
    assert second is not None
    assert first.estimate.mean == pytest.approx(5 / 6)
    assert first.estimate.low is not None
    assert first.estimate.low < 5 / 6
    assert (second.estimate.mean, second.reading) == (1.0, "on every task")
    assert rows[1].best is not None
    assert rows[1].best.estimate.mean == pytest.approx(1 / 6)


def test_the_pareto_front_by_hand() -> None:
    costs = {"fast": (100.0, 0.8), "good": (900.0, 0.95), "beaten": (1000.0, 0.94), "oracle": (1.0, 0.99)}
    records = [
        made_up(name, Task("room", 0, seed), 10, latency_p50_us=cost, latency_p99_us=3 * cost, auc=area)
        for name, (cost, area) in costs.items()
        for seed in range(3)
    ]
    results = results_of(records, privileged=["oracle"])
    found = {each.policy: each for each in pareto_points(Comparison(results, "room"))}
    assert [name for name, each in found.items() if each.front] == ["fast", "good"]
    assert found["good"].median == pytest.approx(0.9)
    plot = pareto_plot(Comparison(results, "room"), policy_styles(costs))
    assert plot is not None
    assert plot.guides[0].x[:2] == pytest.approx([0.1, 0.9])
    drawn = {series.name: series.data() for series in plot.series}
    assert drawn["good"]["right"] == [2.7]
    assert drawn["beaten"]["hollow"] == [True]
    assert len(drawn["fast"]["dots"]) == 3
    assert "low" not in drawn["fast"]


def test_performance_profiles_by_hand() -> None:
    _, task_times = compared(flown({"a": [10, 20, None, None], "b": [20, 10, 30, None]}))
    plot = profile_plot(task_times, policy_styles(("a", "b")))
    assert plot is not None
    lines = {series.name: (series.x, series.y) for series in plot.series}
    assert lines["a"][0][:2] == [1.0, 2.0]
    assert lines["a"][1] == [0.25, 0.5, 0.5]
    assert lines["b"][1] == [0.5, 0.75, 0.75]


def test_privileged_policies_do_not_take_part() -> None:
    _, task_times = compared(flown({"a": [10], "oracle": [1], "b": [12]}, privileged=["oracle"]))
    assert task_times.policies == ["a", "b"]


def test_panels_without_content_are_absent() -> None:
    alone, _ = compared(flown({"a": [10, 20]}))
    panels = scenario_panels(alone, policy_styles(("a",)))
    assert (panels.duels, panels.ranks, panels.rank_plot, panels.pareto, panels.profile) == ([], None, [], None, None)
    nobody, _ = compared(flown({"a": [None], "b": [None]}))
    assert scenario_panels(nobody, policy_styles(("a", "b"))).profile is None
    empty = Comparison(results_of([]), "room")
    assert scenario_panels(empty, {}).causes == []


def test_failures_are_gathered_by_policy_and_cause() -> None:
    def failed(policy: str, seed: int, reason: str, outcome: Outcome = Outcome.FAILED):
        record = made_up(policy, Task("room", 0, seed), None)
        covered = np.full_like(record.covered, 16 * (1 + seed))
        return replace(record, outcome=outcome, reason=reason, covered=covered)

    troubles = [
        failed("a", 0, "ValueError: 7 is no action"),
        failed("a", 1, "ValueError: -3.5 is no action"),
        failed("a", 2, "KeyError: home"),
        failed("b", 0, "UAV 0: collision, UAV 1: out of bounds", Outcome.ENDED),
        failed("b", 2, "UAV 0: out of bounds, UAV 1: collision", Outcome.ENDED),
        failed("b", 3, "UAV 0: collision, UAV 1: collision", Outcome.ENDED),
    ]
    rows = causes(troubles, {"a": 9, "b": 8})
    assert [(row.policy, row.episodes, row.flown) for row in rows] == [
        ("a", 2, 9),
        ("b", 2, 8),
        ("a", 1, 9),
        ("b", 1, 8),
    ]
    assert "7 is no action" in rows[0].cause
    assert rows[1].cause.endswith("collision, out of bounds")
    assert rows[0].coverage.replace("\u202f", " ") == "25.0 % to 50.0 %"
    assert rows[1].seeds == "0, 2"
    assert json.loads(rows[1].replay) == {"policy": "b", "task": [0, 0]}
