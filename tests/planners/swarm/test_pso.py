from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from indoor_explorers.env import World, make_policy, scenario
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.policies.view import Mate
from indoor_explorers.planners.swarm.pso import Pso, PsoPilot
from indoor_explorers.planners.toolbox.coordination.linked_group import NOWHERE, LinkedMember, absentees, linked_members
from tests.planners.flights import fly, rooms, world_on


@pytest.mark.parametrize(("model", "reach"), [("unlimited", 0.0), ("disc", 6.0)])
def test_linked_uavs_compute_the_same_joint_plan(model: str, reach: float) -> None:
    settings = {"team": 4, "radio.model": model, "radio.range": reach}
    world = World(scenario("thesis-obstacles").with_settings(settings).for_evaluation())
    policy, meetings = Pso(), 0
    for seed in range(4):
        world.begin(0, seed, floorplan=Floorplan.from_free(rooms(2, 6, seed), "rooms"))
        pilots = [PsoPilot(world.briefing(0, k), policy) for k in range(4)]
        while world.flying[0].any():
            views = [world.view(0, k) for k in range(4)]
            groups = [
                linked_members(view, pilot.briefing, pilot.message) for pilot, view in zip(pilots, views, strict=True)
            ]
            plans = [pilots[k].plan(views[k], groups[k]) for k in range(4)]
            for k, members in enumerate(groups):
                for member in members:
                    assert plans[member.agent] == plans[k]
                    meetings += member.agent != k
            actions = policy.act(pilots, views)
            for members in groups:
                assert len({(pilots[member.agent].message or ())[2:4] for member in members}) == 1
            for k in range(4):
                world.post(0, k, pilots[k].message)
            world.step(np.array([actions]))
        assert world.team_coverage[0] == 1.0
    assert meetings > 100


def test_goals_are_spread() -> None:
    world = world_on(np.ones((1, 31), np.bool_), [(0, 15), (0, 16)], team=2, radio__model="unlimited")
    policy = make_policy("pso")
    pilots = [policy.pilot(world.briefing(0, k)) for k in range(2)]
    assert list(policy.act(pilots, [world.view(0, k) for k in range(2)])) == [1, 3]


def test_the_latest_news_of_who_is_away_counts() -> None:
    world = World(scenario("thesis-team-4"))
    world.begin(0, 0)
    old, new, gone = Mate(2, (1, 1), 9, None), Mate(2, (3, 3), 4, None), Mate(3, (5, 5), 61, None)
    members = [
        LinkedMember(0, (15, 15), None, NOWHERE, (old, gone)),
        LinkedMember(1, (15, 14), None, NOWHERE, (new, Mate(0, (0, 0), 1, None))),
    ]
    assert absentees(members, world.briefing(0, 0)) == [new]
    near = [member._replace(cell=(3, 4)) for member in members]
    assert absentees(near, world.briefing(0, 0)) == [new]
    assert absentees([near[0]._replace(absent=(new._replace(age=1),))], world.briefing(0, 0)) == []


def test_sectors_drive_uavs_without_radio_apart() -> None:
    spawns = [(20, 20), (20, 21), (21, 20), (21, 21)]

    def spread(sector: float) -> float:
        flight = fly(Pso(sector=sector), np.ones((41, 41), np.bool_), team=4, lidar=5.0, spawns=spawns, seed=3)
        assert flight.complete
        places = [track[18] for track in flight.tracks]
        return float(np.mean([np.hypot(*np.subtract(*pair)) for pair in combinations(places, 2)]))

    assert spread(3.0) > max(15.0, 1.2 * spread(0.0))
