"""The home base: what it knows, whom it tells, and when only its knowledge counts."""

import numpy as np
import pytest

from indoor_explorers.env import InputError, Scenario, World, scenario
from indoor_explorers.env.grid.cells import UNKNOWN
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.simulation.state import End

LEFT, RIGHT, STAY = 1, 3, 4
CORRIDOR = Floorplan(np.ones((1, 24), np.uint8), "corridor")


def in_corridor(cells, radio=None, base=None, **settings):
    """A team in a corridor that sees two cells away; by default the base is where UAV 0 starts."""
    task = Scenario(
        team=len(cells),
        spawn=tuple((0, cell) for cell in cells),
        lidar={"range": 2.0},
        radio=radio or {},
        base=base or {"at": "start"},
        **({"goal": 1.0, "goal_of": "team", "budget": 1000} | settings),
    )
    world = World(task)
    world.begin(0, 7, floorplan=CORRIDOR)
    return world


def fly(world, *actions, steps=1):
    for _ in range(steps):
        world.step(np.array([actions]))


def reported(world):
    return np.flatnonzero(world.state.base_belief[0, 0] != UNKNOWN).tolist()


def known(world, agent):
    return np.flatnonzero(world.view(0, agent).belief[0] != UNKNOWN).tolist()


def test_a_uav_reports_when_it_is_near():
    world = in_corridor((3,))
    assert reported(world) == [1, 2, 3, 4, 5]
    assert world.briefing(0, 0).base == (0, 3)
    fly(world, RIGHT)
    assert (reported(world)[-1], world.view(0, 0).base_age) == (6, 0)
    fly(world, RIGHT, steps=4)
    assert (reported(world)[-1], world.view(0, 0).base_age) == (6, 4)
    assert world.base_coverage[0] == 6 / 24 < world.team_coverage[0] == 10 / 24
    fly(world, LEFT, steps=4)
    assert (reported(world)[-1], world.view(0, 0).base_age) == (10, 0)
    assert world.state.sent_bytes[0, 0] == 5 * 10


def test_reports_pass_through_teammates():
    world = in_corridor((3, 6, 9), {"model": "disc", "range": 3.0})
    assert reported(world) == list(range(1, 12))
    fly(world, STAY, STAY, RIGHT)
    assert reported(world)[-1] == 11
    fly(world, STAY, RIGHT, STAY)
    fly(world, RIGHT, STAY, STAY)
    assert reported(world)[-1] == 12
    assert world.state.base_contact[0].tolist() == [True, True, True]


def test_the_base_tells_what_others_have_reported():
    world = in_corridor((3, 12), base={"at": (0, 7), "radius": 0.0})
    fly(world, RIGHT, LEFT, steps=4)
    assert known(world, 0) == list(range(1, 10))
    fly(world, LEFT, LEFT)
    assert reported(world) == list(range(1, 15))
    assert known(world, 1) == list(range(1, 15))
    assert known(world, 0) == list(range(1, 10))


def test_a_contact_with_the_base_is_one_between_those_who_have_it():
    world = in_corridor((3, 11), base={"at": (0, 7)})
    fly(world, RIGHT, LEFT, steps=3)
    assert known(world, 0) == known(world, 1) == list(range(1, 14))
    assert not world.state.linked.any()


@pytest.mark.parametrize("must_return", [False, True])
def test_only_reports_count_where_uavs_must_return(must_return):
    world = in_corridor((0,), base={"at": "start", "must_return": must_return})
    fly(world, RIGHT, steps=21)
    assert world.team_coverage[0] == 1.0
    assert world.state.end[0, 0] == (End.FLYING if must_return else End.GOAL)
    if must_return:
        fly(world, LEFT, steps=19)
        assert world.flying.all()
        fly(world, LEFT)
        assert world.state.end[0, 0] == End.GOAL
        assert world.base_coverage[0] == 1.0


def test_what_was_reported_outlives_the_uav():
    world = in_corridor((2, 5), failures={"stops": ((1, 2),)}, base={"at": (0, 5)})
    fly(world, STAY, RIGHT, steps=2)
    assert reported(world) == [3, 4, 5, 6, 7, 8]
    assert world.team_coverage[0] == 9 / 24  # cell 9 was seen in the last step alone


@pytest.mark.parametrize(
    ("base", "message"),
    [
        ({"at": (0, 24)}, r"base.at \(0, 24\) is no cell of this 1 x 24 map that can be reached"),
        ({"at": (3, 3)}, "list another one, or use 'start'"),
    ],
)
def test_bases_that_cannot_be_are_refused(base, message):
    settings = {f"base.{name}": value for name, value in base.items()}
    with pytest.raises(InputError, match=message):
        World(scenario("thesis-open").with_settings(settings)).begin(0, 1, floorplan=CORRIDOR)


def test_a_listed_base_is_checked_in_rooms_that_are_drawn():
    World(scenario("thesis-obstacles").with_settings({"base.at": (8, 8), "map.obstacles": 0})).reset([3])
    with pytest.raises(InputError, match=r"base\.at"):
        World(scenario("thesis-obstacles").with_settings({"base.at": (16, 8)})).reset([3])
