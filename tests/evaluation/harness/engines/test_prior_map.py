"""A comparison with a prior map, of which isolated policies are told."""

import pytest

from indoor_explorers.env import World, scenario
from indoor_explorers.evaluation import compare
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.studies.leaderboard.verifying import mismatches


@pytest.mark.parametrize(("isolate", "workers"), [pytest.param("all", 1, marks=pytest.mark.slow), ("none", 0)])
def test_policies_in_any_process_are_given_the_prior_of_their_episode(tmp_path, isolate, workers):
    settings = {"prior.kind": "outdated", "budget": 20}
    use = "tests.evaluation.plugins:ToldOfThePrior"
    how = {"isolate": isolate, "workers": workers}
    compare(tmp_path, policies=[use], scenario="small-floors", episodes=2, settings=settings, **how)
    results = Results.load(tmp_path)
    assert list(mismatches(results)) == []
    for record in results.records:
        world = World(scenario("small-floors").for_evaluation().with_settings(settings))
        world.reset([record.task.seed])
        assert record.metrics["pilot_prior"] == world.prior(0).sum()
        assert record.metrics["pilot_fixed"] == 1.0
