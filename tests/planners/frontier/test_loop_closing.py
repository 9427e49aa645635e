"""Active loop closing flies as its explorer where nothing drifts, and shows more of the map rightly where poses do."""

import numpy as np
import pytest

from indoor_explorers.env import InputError, make_policy
from indoor_explorers.planners.frontier.loop_closing import LoopClosing
from tests.planners.flights import fly_preset


def flown(policy, seed, **settings):
    """The world after an episode, its pilots, and the cells of all UAVs at each step."""
    return fly_preset(policy, "small-floors", seed, **settings)


def wrong(world):
    shown = world.state.union[0]
    return int(((shown != 0) & (shown != world.state.truth[0])).sum())


@pytest.mark.parametrize("explorer", ["frontier", "frontier-nearest"])
@pytest.mark.parametrize("settings", [{}, {"noise.misses": 0.1}], ids=["exact", "noise"])
def test_without_drift_it_is_the_explorer(explorer, settings):
    settings = settings | {"team": 2, "budget": 150}
    alone = flown(make_policy(explorer), 3, **settings)[2]
    assert np.array_equal(flown(LoopClosing(explorer=explorer), 3, **settings)[2], alone)


@pytest.mark.slow
def test_it_shows_more_rightly_than_its_explorer():
    explorer, found = [], []
    for seed in range(9_700_002, 9_700_030, 9):
        settings = {"drift.rate": 0.004, "budget": 600}
        explorer.append(wrong(flown(make_policy("frontier-nearest"), seed, **settings)[0]))
        found.append(wrong(flown(LoopClosing(explorer="frontier-nearest"), seed, **settings)[0]))
    assert sum(explorer) > 40
    assert sum(found) < 0.7 * sum(explorer)


def test_a_slip_is_noticed_and_corrected_within_some_steps():
    world, pilots, _ = flown(LoopClosing(explorer="frontier-nearest"), 9_700_002, **{"drift.rate": 0.002})
    tally = pilots[0, 0].tally()
    assert tally["slips"] == 1
    assert 1 <= tally["closing"] <= 20
    assert wrong(world) == 0
    assert world.team_coverage[0] == 1.0


@pytest.mark.slow  # seven seconds
def test_a_team_tells_each_other_its_errors_and_the_explorers_do_not_see_them():
    world, pilots, _ = flown(LoopClosing(), 4, **{"team": 2, "drift.rate": 0.02, "budget": 80})
    assert all(len(pilot.message) >= 2 for pilot in pilots.values())
    assert world.team_coverage[0] > 0.1


def test_an_explorer_that_is_given_the_map_is_refused():
    with pytest.raises(InputError, match="not given the map"):
        LoopClosing(explorer="reference")


@pytest.mark.parametrize("parameters", [{"doubt": 0.0}, {"doubt": 1.0}, {"scan_cost": -1.0}])
def test_parameters_out_of_bounds_are_refused(parameters):
    with pytest.raises(InputError, match="expected"):
        LoopClosing(**parameters)
