"""The study of reports on drawn tasks: its points, and its table."""

import pytest

from indoor_explorers.evaluation.site.studies.report_tasks import LATE_COSTS, Flown, learned, policies, table


@pytest.mark.parametrize("late_cost", [0.0, 15.0])
def test_points_are_coverage_less_what_comes_too_late(late_cost):
    assert Flown(0.6, 0.99).points(late_cost) == 60.0
    assert Flown(0.6, 0.985).points(late_cost) == pytest.approx(60.0 - late_cost * 0.55)
    assert Flown(0.6, 0.5).points(late_cost) == 60.0 - late_cost


def test_the_learner_is_compared_with_each_rule_on_the_same_tasks_and_at_the_same_cost():
    flights = [
        {"a rule": Flown(0.5, 1.0)} | {learned(cost): Flown(0.6, 1.0) for cost in LATE_COSTS},
        {"a rule": Flown(0.3, 1.0)} | {learned(cost): Flown(0.4, 0.2) for cost in LATE_COSTS},
    ]
    heading, _, rule, *own = table(flights).splitlines()
    assert {line.count("|") for line in (heading, rule, *own)} == {4 + len(LATE_COSTS)}
    assert rule == "| a rule | 0.400 | 100\u202f% | 10.0 | 2.5 | \N{MINUS SIGN}20.0 | \N{MINUS SIGN}140.0 |"
    assert [line.split(" | ")[1:3] for line in own] == [["0.500", "50\u202f%"]] * len(LATE_COSTS)
    assert all(own[k].split("|")[4 + k].strip() == "" for k in range(len(LATE_COSTS)))


def test_all_have_one_explorer():
    assert {policy.explorer for policy in policies().values()} == {"frontier-predictive"}
