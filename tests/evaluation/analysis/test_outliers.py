"""Chance and what is far behind determine no range of a chart."""

from __future__ import annotations

from dataclasses import replace

import pytest

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.outliers import far_behind
from indoor_explorers.evaluation.analysis.panels.pareto_plot import pareto_plot
from indoor_explorers.evaluation.analysis.panels.performance_profile import profile_plot
from indoor_explorers.evaluation.analysis.tables.results_table import columns_of, results_table
from indoor_explorers.evaluation.analysis.task_times import TaskTimes
from indoor_explorers.evaluation.drawing.palette import policy_styles
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report.charts.interactive import times_data
from indoor_explorers.evaluation.report.page import render
from tests.evaluation.report.records import made_up, results_of


def records_of(policy: str, late: float, area: float) -> list[Record]:
    return [
        made_up(policy, Task("room", 0, seed), late + seed, auc=area, latency_p50_us=500.0, latency_p99_us=900.0)
        for seed in range(6)
    ]


@pytest.fixture
def results() -> Results:
    found = results_of([*records_of("chance", 29, 0.3), *records_of("good", 20, 0.9), *records_of("fair", 25, 0.85)])
    chance = found.policies["chance"] | {"plans_for": "nothing"}
    return replace(found, policies=found.policies | {"chance": chance})


def test_chance_is_far_behind_by_its_aim_and_others_by_their_times(results: Results) -> None:
    assert far_behind(Comparison(results, "room")) == ["chance"]
    slow = results_of([*records_of("slow", 80, 0.3), *records_of("good", 20, 0.9)])
    assert far_behind(Comparison(slow, "room")) == ["slow"]
    alone = replace(results, records=[r for r in results.records if r.policy == "chance"])
    assert far_behind(Comparison(alone, "room")) == []


def test_ranges_are_those_of_the_others(results: Results) -> None:
    comparison, styles = Comparison(results, "room"), policy_styles(results.policies)
    pareto = pareto_plot(comparison, styles)
    assert pareto is not None
    assert 0.8 < pareto.y.low < 0.85
    assert pareto.beyond == "Out of range: chance, AUC 0.300 [0.300, 0.300] at 0.500 ms."
    profile = profile_plot(TaskTimes.of(comparison), styles, far_behind(comparison))
    assert profile is not None
    assert 25 / 20 < profile.x.high < 29 / 20
    assert times_data(comparison, styles)["focus"] == int(30 * 1.05) + 1
    assert pareto.beyond in render(results)


def test_a_mean_beyond_the_scale_of_the_dots_is_an_arrowhead(results: Results) -> None:
    comparison, styles = Comparison(results, "room"), policy_styles(results.policies)
    place = [column.kind for column in columns_of(comparison.level)].index("dots")
    drawn = {name: str(cells[place].detail) for name, cells, _ in results_table(comparison, styles)}
    assert {name: 'class="beyond"' in text for name, text in drawn.items()} == {
        "chance": True,
        "good": False,
        "fair": False,
    }


def test_chance_and_who_knows_the_map_share_a_colour_with_nobody() -> None:
    facts = {f"p{number}": {"privileged": False} for number in range(12)}
    styles = policy_styles(
        {"random": {"plans_for": "nothing"}, **facts, "reference": {"privileged": True, "plans_for": "all cells"}}
    )
    assert list(styles) == ["random", *facts, "reference"]
    others = {styles[name].colour for name in facts}
    assert styles["random"].colour != styles["reference"].colour
    assert not others & {styles["random"].colour, styles["reference"].colour}
    assert len({styles[name][:2] for name in facts}) == len(facts)
