"""The study of reports on drawn tasks: its points, and its table."""

from importlib.resources import files

from indoor_explorers.evaluation.site.studies.report_tasks import LEARNED, Flown, policies, table


def test_points_are_coverage_less_what_comes_too_late():
    assert Flown(0.6, 0.99).points == 60.0
    assert Flown(0.6, 0.985).points == 60.0 - 7.5 - 0.75
    assert Flown(0.6, 0.5).points == 60.0 - 15.0


def test_the_learner_is_compared_with_each_rule_on_the_same_tasks():
    flights = [
        {"a rule": Flown(0.5, 1.0), LEARNED: Flown(0.6, 1.0)},
        {"a rule": Flown(0.3, 1.0), LEARNED: Flown(0.4, 0.2)},
    ]
    heading, _, rule, learned = table(flights).splitlines()
    assert heading.count("|") == rule.count("|") == learned.count("|") == 6
    assert rule.startswith("| a rule | 0.400 | 100")
    assert "| 40.0 | 2.5" in rule
    assert learned.startswith(f"| {LEARNED} | 0.500 | 50")


def test_the_rules_are_those_of_one_explorer():
    assert {policy.explorer for policy in policies().values()} == {"frontier-predictive"}


def test_other_trainings_of_the_learner_fly_beside_the_one_that_ships():
    shipped = files("indoor_explorers.learners.reports").joinpath("weights", "reports.safetensors")
    assert list(policies([str(shipped)]))[-2:] == [str(shipped), LEARNED]
    assert policies([str(shipped)])[str(shipped)].provenance() == policies()[LEARNED].provenance()
