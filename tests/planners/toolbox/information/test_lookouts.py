"""Lookouts see into clusters from near the UAV; each view is flown to once, and no UAV flies to and fro."""

import numpy as np
import pytest

from indoor_explorers.env import make_policy
from indoor_explorers.env.grid.cells import FREE, UNKNOWN
from indoor_explorers.env.search.connected_parts import largest_part
from indoor_explorers.planners.frontier.latency import FrontierLatency
from indoor_explorers.planners.toolbox.information.lookouts import NEAR, Lookouts
from indoor_explorers.planners.toolbox.information.view_gain import visible_sets
from tests.planners.flights import fly, fly_preset, view_of, world_on

#: A hall of which the part behind a table is not known.
HALL = np.full((15, 21), FREE, np.uint8)
HALL[[0, -1]] = HALL[:, [0, -1]] = 2
HALL[7, 8:15] = 2
HALL[8:13, 10:14] = UNKNOWN


def in_hall():
    """A pilot in the hall with a lidar of ten cells, its lookouts, and its view from the left of the table."""
    pilot = FrontierLatency().pilot(world_on(np.ones(HALL.shape, np.bool_), lidar__range=10.0).briefing(0, 0))
    return pilot, Lookouts(pilot, pilot._found, 1.0, 8), view_of(HALL, (9, 4))


def steps_to_99(policy, scenario, seed, **settings):
    return len(fly_preset(policy, scenario, seed, goal=0.99, team=1, budget=1500, **settings)[2])


def viewpoints(pilot, view):
    found = pilot._found.found(view)
    gains = pilot._found.views(view, found.cells)
    return found, pilot._found.best_of_each(found.owner, gains, np.zeros(len(gains), np.bool_))


def test_lookouts_are_near_and_see_into_their_clusters():
    pilot, lookouts, view = in_hall()
    found, best = viewpoints(pilot, view)
    among = lookouts.added_to(view, found)
    added = slice(len(found.cells), None)
    assert 1 <= len(among.cells[added]) <= 8
    assert np.array_equal(among.cells[: len(found.cells)], found.cells)
    assert (among.steps[added] <= pilot.steps_in(NEAR)).all()
    assert not np.isin(among.cells[added], found.cells).any()
    for cell, owner in zip(among.cells[added], among.owner[added], strict=True):
        sets = visible_sets(view.belief, np.array([cell, found.cells[best[owner]]], np.int32), pilot.lidar)
        assert (sets[0] & sets[1]).any()


def test_where_a_uav_has_been_is_no_lookout():
    pilot, lookouts, view = in_hall()
    found, _ = viewpoints(pilot, view)
    been = view._replace(visited=np.ones(HALL.shape, np.bool_))
    assert lookouts.added_to(been, found) is found


def test_a_lookout_is_kept_until_it_is_reached_or_half_of_its_gain_is_lost():
    pilot, lookouts, view = in_hall()
    pilot.lookouts = lookouts
    found, _ = viewpoints(pilot, view)
    among = lookouts.added_to(view, found)
    frontier, lookout = (divmod(int(among.cells[k]), HALL.shape[1]) for k in (0, -1))
    pilot.navigator.observe(view)
    pilot.choose = lambda _: lookout
    pilot.choose_goal(view)
    assert pilot.goal == lookout
    assert not pilot.is_spent(view, lookout)
    assert pilot.is_spent(view._replace(cell=lookout), lookout)
    seen = HALL.copy()
    seen[8:13, 10:14] = FREE
    assert pilot.is_spent(view._replace(belief=seen), lookout)
    pilot.choose = lambda _: frontier
    pilot.choose_goal(view)
    assert not pilot.is_spent(view, frontier)
    assert pilot.is_spent(view, lookout)


def test_viewpoints_that_a_better_one_covers_are_left_out():
    pilot, lookouts, view = in_hall()
    cells = pilot.paths.flat([(12, 9), (12, 9), (2, 2), (8, 16)])
    kept = lookouts.distinct(view, cells)
    assert kept.tolist()[:2] == [True, False]
    sets = visible_sets(view.belief, cells, pilot.lidar)
    first, last = (int.from_bytes(each.tobytes(), "little") for each in sets[[0, 3]])
    assert kept[3] == ((first & last).bit_count() < 0.5 * last.bit_count())


@pytest.mark.parametrize(
    ("scenario", "seed"), [("small-halls", 9_600_025), ("small-cave", 9_600_015), ("small-storeys", 3)]
)
@pytest.mark.parametrize("policy", ["frontier-latency", "frontier-predictive"])
def test_uavs_do_not_fly_to_and_fro_between_lookouts(policy, scenario, seed):
    """With choices anew at every step ``frontier-predictive`` would in the first of these maps."""
    assert steps_to_99(make_policy(policy, lookouts=8), scenario, seed) < 900


@pytest.mark.parametrize(
    ("scenario", "seed"),
    [
        ("tall-halls", 22_000_003),
        pytest.param("racks", 22_000_017, marks=pytest.mark.slow),
        pytest.param("stair-wells", 22_000_009, marks=pytest.mark.slow),
    ],
)
def test_networks_do_not_fly_to_and_fro_between_lookouts(scenario, seed):
    """With choices anew at every step ``dddqn-places`` would in each of these buildings."""
    policy = make_policy("dddqn-places", lookouts=8, level_weights="shipped")
    assert steps_to_99(policy, scenario, seed, **{"lidar.elevation": 15}) < 900


def furnished(seed):
    """A hall of 16 x 20 cells with fourteen tables of 1 x 2 cells."""
    rng, free = np.random.default_rng(seed), np.ones((16, 20), np.bool_)
    for row, col in zip(rng.integers(1, 15, 14), rng.integers(1, 17, 14), strict=True):
        free[row, col : col + 2] = False
    return largest_part(free)


def test_furnished_halls_are_explored_sooner():
    """The sum over twelve halls; each by itself may go either way."""

    def steps(lookouts):
        policy = make_policy("frontier-latency", lookouts=lookouts)
        return sum(fly(policy, furnished(seed), lidar=10.0).steps for seed in range(12))

    assert steps(8) < 0.95 * steps(0)
