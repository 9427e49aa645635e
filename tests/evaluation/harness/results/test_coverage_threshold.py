"""The level that a scenario is judged by, and what the goal leaves out."""

import pytest

from indoor_explorers.evaluation.harness.episodes.metrics import LEVELS, MEASURES
from indoor_explorers.evaluation.harness.results.coverage_threshold import (
    CoverageThreshold,
    applies_to,
    drawn,
    shared,
    tabled,
    threshold_of,
)


@pytest.mark.parametrize(
    ("goal", "key"),
    [(1.0, "t99"), (0.99, "t99"), (0.98, "t95"), (0.95, "t95"), (0.9, "t90"), (0.8, "t50"), (0.5, "t50"), (0.2, "t50")],
)
def test_a_scenario_is_judged_by_the_highest_level_that_its_goal_asks_for(goal: float, key: str) -> None:
    level = threshold_of(goal)
    assert level.key == key
    assert applies_to(goal, level.key)


def test_a_goal_asks_for_times_up_to_it_and_for_everything_else() -> None:
    asked = {metric for metric in MEASURES if applies_to(0.95, metric)}
    assert MEASURES.keys() - asked == {"t98", "t99", "t99_base", "t99_worst", "t99_to_bound", "t99_to_reference"}
    assert all(applies_to(1.0, metric) for metric in MEASURES)
    assert {metric for metric in LEVELS if applies_to(0.2, metric)} == {"t50"}
    assert applies_to(0.5, "pilot_t99")


def test_a_level_has_its_names() -> None:
    level = CoverageThreshold("t95")
    assert (level.share, level.percent, level.title) == (0.95, "95 %", "T95")


def test_what_is_drawn_is_asked_for_and_tables_have_a_column_for_the_usual_times() -> None:
    assert [CoverageThreshold(key).times for key in ("t99", "t95", "t90", "t50")] == [
        *[("t90", "t99"), ("t90", "t95"), ("t90",), ("t50",)]
    ]
    levels = [CoverageThreshold("t99"), CoverageThreshold("t90"), CoverageThreshold("t95")]
    assert tabled(levels[:2]) == ("t90", "t99")
    assert tabled(levels) == drawn(levels) == ("t90", "t95", "t99")
    assert drawn(levels[1:2]) == ("t90",)


def test_only_equal_levels_are_shared() -> None:
    assert shared([CoverageThreshold("t90"), CoverageThreshold("t90")]) == CoverageThreshold("t90")
    assert shared([CoverageThreshold("t90"), CoverageThreshold("t99")]) is None
    assert shared([]) is None
