"""A comparison with a home base: what isolated policies are told of it, and what they declare."""

import pytest

from indoor_explorers.evaluation import compare
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.studies.leaderboard.verifying import mismatches


@pytest.mark.slow
def test_a_comparison_shows_the_base_and_isolated_policies_know_it(tmp_path):
    policies = ["frontier-nearest", "tests.evaluation.plugins:ToldOfTheBase"]
    settings = {"base.at": "start", "base.must_return": True, "on_collision": "block", "budget": 60}
    compare(tmp_path, policies=policies, scenario="thesis-team-2", episodes=2, settings=settings, workers=1)
    results = Results.load(tmp_path)
    assert list(mismatches(results)) == []
    told = [record.metrics["pilot_base_age"] for record in results.records if record.policy == policies[1]]
    assert min(told) > 0
    done = [record.metrics.get("done_step") for record in results.records if record.policy == policies[1]]
    assert done == [7.0, 7.0]
    page = (tmp_path / "report.html").read_text()
    assert "has been reported to the home base" in page
    assert "Any UAV or base" in page
