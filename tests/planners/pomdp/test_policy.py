from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import World, make_policy, scenario
from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.planners.pomdp.policy import Pomdp, PomdpPilot, Window
from indoor_explorers.planners.toolbox.frontiers.clusters import frontier_clusters
from tests.planners.flights import fly, rooms


@pytest.mark.parametrize("reach", [1, 4, 50])
def test_a_window_holds_what_is_around_a_cell(belief: Belief, start: Cell, reach: int) -> None:
    window = Window(belief, start, reach)
    at = int(window.flat(np.array([start[0] * belief.shape[1] + start[1]], np.int32))[0])
    assert window.belief.flat[at] == belief[start]
    rows, cols = (slice(max(0, place - reach), place + reach + 1) for place in start)
    assert np.array_equal(window.belief, belief[rows, cols])
    if reach == 50:
        clusters, inside = frontier_clusters(belief, 3.0), window.clusters(frontier_clusters(belief, 3.0))
        assert inside.cells.tolist() == clusters.cells.tolist()
        assert inside.ends.tolist() == clusters.ends.tolist()


def test_clusters_outside_of_a_window_are_empty() -> None:
    belief = np.zeros((1, 40), np.uint8)
    belief[0, 3:6] = belief[0, 30:33] = 1
    clusters = frontier_clusters(belief, 3.0)
    inside = Window(belief, (0, 4), 3).clusters(clusters)
    assert inside.size == clusters.size
    assert np.diff(inside.ends).sum() == 2
    assert set(inside.cells.tolist()) == {3 - 1, 5 - 1}


def test_it_leaves_a_frontier_to_the_linked_teammate_that_flies_there() -> None:
    world = World(scenario("thesis-team-2").with_settings({"radio.model": "unlimited", "lidar.range": 3.0}))
    free = np.ones((1, 41), np.bool_)
    world.begin(0, 0, floorplan=Floorplan.from_free(free, "corridor"), spawns=[(0, 20), (0, 21)])
    world.post(0, 1, (0.0, 17.0))
    world.step(np.array([[4, 4]]))
    pilot = PomdpPilot(world.briefing(0, 0), Pomdp(dimming=1.0))
    pilot.act(world.view(0, 0))
    assert pilot.goal == (0, 24)
    assert pilot.message == (0.0, 24.0)


def test_far_from_all_frontiers_it_flies_to_the_nearest() -> None:
    flight = fly(make_policy("pomdp", horizon=4.0), rooms(2, 6, 1), lidar=2.0)
    assert flight.complete
    tally = flight.pilots[0].tally()
    assert 0 < tally["out_of_range"] < tally["plans"]


def test_a_team_explores_with_few_simulations() -> None:
    policy = make_policy("pomdp", simulations=1, maps=1, tree=1)
    assert fly(policy, rooms(2, 4, 1), team=3, radio=("disc", 6.0)).complete


def test_it_tells_of_its_estimates() -> None:
    assert set(Pomdp().provenance()) == {"pocket_weights"}
    assert not Pomdp.uses_generator
