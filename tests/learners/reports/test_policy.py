"""Flights with learned reports: in time, as the explorer where there is no base, and by what the network says."""

import re

import numpy as np
import pytest
import torch

from indoor_explorers.env import InputError, World, make_policy, scenario
from indoor_explorers.learners.reports.learning import AdvantageNet
from indoor_explorers.learners.reports.network import load_weights, value, write_weights
from indoor_explorers.learners.reports.policy import NAME, DddqnReports, opened
from indoor_explorers.learners.reports.situation import NUMBERS, Situation
from indoor_explorers.planners.return_to_base import ReturnToBase
from tests.planners.flights import fly_preset

HOME = {"base.at": "start", "base.must_return": True, "budget": 400}


def some_network(bias: float = 0.0) -> AdvantageNet:
    torch.manual_seed(3)
    network = AdvantageNet()
    torch.nn.init.normal_(network.layers[-1].weight, std=0.1)
    torch.nn.init.constant_(network.layers[-1].bias, bias)
    return network


def policy_of(folder, bias: float, explorer: str = "frontier-nearest") -> DddqnReports:
    write_weights(folder / NAME, some_network(bias).weights())
    return opened(str(folder), explorer=explorer)


def test_it_computes_what_torch_computes(tmp_path):
    network = some_network()
    write_weights(tmp_path / NAME, network.weights())
    numbers = np.random.default_rng(0).normal(size=(20, NUMBERS)).astype(np.float32)
    with torch.no_grad():
        expected = network(torch.from_numpy(numbers)).squeeze(1).numpy() + 0.25
    found = [value(Situation(row, 0.25), load_weights(tmp_path / NAME)) for row in numbers]
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-5)


def test_untrained_it_is_the_rule(tmp_path):
    write_weights(tmp_path / NAME, AdvantageNet().weights())
    ones = np.ones(NUMBERS, np.float32)
    assert [value(Situation(ones, rule), load_weights(tmp_path / NAME)) for rule in (-1.5, 2.0)] == [-1.5, 2.0]


@pytest.mark.parametrize("team", [1, 3])
def test_uavs_are_home_in_time_and_the_higher_the_value_the_more_flights(tmp_path, team):
    flights = []
    for bias in (-100.0, 0.0, 100.0):
        world, pilots, _ = fly_preset(policy_of(tmp_path, bias), "small-offices", 3, team=team, **HOME)
        assert world.base_coverage[0] == world.team_coverage[0] > 0.2
        flights.append(sum(pilots[0, n].tally()["flights_home"] for n in range(team)))
    assert flights == sorted(flights)
    assert flights[0] < flights[-1]


def test_never_worth_it_is_one_flight_at_the_deadline(tmp_path):
    found = fly_preset(policy_of(tmp_path, -100.0), "small-offices", 4, team=2, **HOME)[2]
    alone = fly_preset(ReturnToBase(explorer="frontier-nearest", when="deadline"), "small-offices", 4, team=2, **HOME)[
        2
    ]
    assert np.array_equal(found, alone)


def test_it_tells_the_latest_value_of_flying_home(tmp_path):
    world = World(scenario("small-offices").for_evaluation().with_settings({"team": 1} | HOME))
    world.reset([3])
    pilot = policy_of(tmp_path, -100.0).pilot(world.briefing(0, 0))
    pilot.explaining = True
    for _ in range(30):
        world.step([[pilot.act(world.view(0, 0))]])
    told = pilot.explain().note
    assert re.search(r"at step 2\d flying home had the value -\d+\.\d\d, exploring on 0$", told)


def test_without_a_base_it_is_the_explorer(tmp_path):
    found = fly_preset(policy_of(tmp_path, 100.0, "frontier"), "small-offices", 3, team=2, budget=100)[2]
    assert np.array_equal(found, fly_preset(make_policy("frontier"), "small-offices", 3, team=2, budget=100)[2])


def test_it_declares_both_networks(tmp_path):
    declared = policy_of(tmp_path, 0.0, "dddqn-places").provenance()
    assert make_policy("dddqn-places").provenance().items() < declared.items()
    assert len(declared["reports_sha256"]) == 64


def test_it_has_seen_what_the_estimates_were_learned_from_whoever_explores(tmp_path):
    seen = policy_of(tmp_path, 0.0, "rrt")
    assert seen.seen_maps() == make_policy("frontier-predictive").seen_maps() != {}
    assert "pocket_weights" in seen.provenance()


def test_missing_weights_are_refused(tmp_path):
    with pytest.raises(InputError, match=NAME):
        opened(str(tmp_path))
