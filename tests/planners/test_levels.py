"""Planners on maps of several levels: those that change levels explore all, the others stay on theirs."""

import numpy as np

from indoor_explorers.env import World, make_policy, scenario
from tests.behaviour.policies import ALIKE, parametrized
from tests.planners.flights import fly_preset

TASK = scenario("small-storeys").for_evaluation()
CHANGE = (
    *("frontier-nearest", "frontier-utility", "frontier-burgard", "frontier-hungarian", "frontier-minpos"),
    *("frontier-mrtsp", "frontier-octree", "frontier-tour", "frontier-advantage", "frontier-latency", "frontier"),
    *("frontier-predictive", "pso", "pso-predictive", "bat", "gso", "aco", "hedac"),
    *("rrt", "rrt-nbv", "rrt-frontier", "rrt-predictive", "prm-tour", "cover-tour"),
    *("dddqn-places", "dddqn", "horizon", "reference"),
)


def flown(name, seed, **parameters):
    """The world at the end of an episode."""
    return fly_preset(make_policy(name, **parameters), TASK.name, seed, team=2)[0]


def levels_of(world):
    """The levels that the UAVs were on."""
    levels = world.briefing(0, 0).levels
    return {levels.voxel((row, 0))[0] for row in np.flatnonzero(world.state.visited[0].any(axis=(0, 2))).tolist()}


@parametrized(CHANGE, slow=ALIKE)
def test_planners_that_change_levels_explore_all_of_them(name):
    world = flown(name, 3)
    assert world.team_coverage[0] == 1.0
    assert not world.state.collisions.any()
    assert len(levels_of(world)) > 3


def test_estimates_over_levels_are_used_where_they_are_asked_for():
    """By default there are none; where there are, the control's true sizes come from all levels."""
    names = ("frontier-predictive", "dddqn-places", "pso-predictive", "rrt-predictive")
    flights = {
        name: [flown(name, 3, **each).state.step[0] for each in ({}, {"level_weights": "shipped"})] for name in names
    }
    assert all(plain != level for plain, level in flights.values())
    informed = "indoor_explorers.planners.frontier.informed:FrontierInformed"
    told = flown(informed, 3, level_weights="shipped")
    assert told.team_coverage[0] == 1.0
    assert told.state.step[0] != flown(informed, 3).state.step[0]
    hashes = make_policy("dddqn-places", level_weights="shipped").provenance()
    assert sorted(hashes) == ["level_weights", "pocket_weights", "weights_sha256"]
    assert sorted(make_policy("dddqn-places").provenance()) == ["pocket_weights", "weights_sha256"]


def test_a_plan_for_one_level_stays_there_until_the_budget_is_flown():
    world = flown("pso-robots", 3)
    again = World(TASK)
    again.reset([3])
    assert levels_of(world) == levels_of(again)
    assert world.team_coverage[0] < 1.0


def test_forms_of_utility_count_cells_on_all_levels():
    assert flown("frontier-utility", 3, form="discounted").team_coverage[0] == 1.0
