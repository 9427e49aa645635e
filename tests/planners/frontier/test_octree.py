"""Octree blocks of frontier cells: every cell in one block, and the one with the most to see for each step."""

from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import InputError, World, make_policy, scenario
from indoor_explorers.env.search.frontiers import frontier_mask
from indoor_explorers.planners.frontier.octree import FrontierOctree, OctreePilot
from tests.planners.flights import fly_preset


def pilot_in(name: str, seed: int, block: float = 0.5) -> tuple[OctreePilot, World]:
    """A pilot and its world at the start of an episode."""
    world = World(scenario(name).with_settings({"team": 1}))
    world.reset(seeds=[seed])
    return OctreePilot(world.briefing(0, 0), FrontierOctree(block=block)), world


@pytest.mark.parametrize("name", ["small-floors", "small-storeys"])
@pytest.mark.parametrize(("block", "side"), [(0.1, 1), (0.5, 2), (1.0, 4), (2.0, 8)])
def test_each_frontier_cell_is_in_one_block(name, block, side):
    pilot, world = pilot_in(name, 1, block)
    view = world.view(0, 0)
    clusters = pilot.clusters(view)
    assert np.array_equal(np.sort(clusters.cells), np.flatnonzero(frontier_mask(view.belief, pilot.paths.rise)))
    blocks = [clusters.cells[a:b] for a, b in zip(clusters.ends, clusters.ends[1:], strict=False)]
    places = [np.unique(pilot.coordinates(cells) // side, axis=0) for cells in blocks]
    assert all(len(cells) for cells in blocks)
    assert all(len(each) == 1 for each in places)
    assert len(np.unique(np.concatenate(places), axis=0)) == len(blocks)


def test_a_known_map_has_no_blocks():
    pilot, world = pilot_in("small-floors", 1)
    view = world.view(0, 0)
    known = view._replace(belief=np.where(view.belief == 0, 2, view.belief).astype(np.uint8))
    assert pilot.clusters(known).size == 0
    assert pilot.choose(known) is None


def test_the_score_is_the_gain_for_each_step():
    pilot, _ = pilot_in("small-floors", 1)
    scores = pilot.score(np.array([6.0, 6.0, 12.0]), np.array([[2.0, 3.0, 6.0], [-1.0, 1.0, 0.0]]))
    np.testing.assert_allclose(scores, [[3.0, 2.0, 2.0], [6.0, 6.0, 12.0]])


@pytest.mark.parametrize(("name", "team"), [("small-floors", 3), ("small-storeys", 1), ("small-storeys", 2)])
def test_it_explores_all_with_any_team_on_plain_maps_and_over_levels(name, team):
    world, _, _ = fly_preset(FrontierOctree(), name, 2, team=team)
    assert world.team_coverage[0] >= 0.99


def test_bad_parameters_are_refused():
    with pytest.raises(InputError, match="block"):
        make_policy("frontier-octree", block=-1)
