from __future__ import annotations

import numpy as np

from indoor_explorers.env import World, make_policy, scenario
from indoor_explorers.env.lidar import view_gain
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.planners.gains import bit_count, sights
from indoor_explorers.planners.swarm.pso import Pso, PsoPilot


def test_linked_uavs_compute_the_same_joint_plan() -> None:
    settings = {"team": 4, "radio.model": "unlimited"}
    world = World(scenario("thesis-obstacles").with_settings(settings).for_evaluation())
    policy = Pso()
    for seed in range(5):
        world.reset([seed])
        pilots = [PsoPilot(world.briefing(0, k), policy) for k in range(4)]
        while world.flying[0].any():
            views = [world.view(0, k) for k in range(4)]
            plans = [pilot.plan(view, pilot.group(view)) for pilot, view in zip(pilots, views, strict=True)]
            assert plans == plans[:1] * 4
            actions = policy.act(pilots, views)
            assert len({(pilot.message or ())[2:] for pilot in pilots}) == 1
            for k in range(4):
                world.post(0, k, pilots[k].message)
            world.step(np.array([actions]))
        assert world.team_coverage[0] == 1.0


def test_sights_are_the_visible_unknown_cells() -> None:
    rng = np.random.default_rng(2)
    belief = rng.choice([0, 1, 2], (20, 20), p=[0.5, 0.4, 0.1]).astype(np.uint8)
    cells = np.flatnonzero(belief == 1).astype(np.int32)[:30]
    for cell, bits in zip(cells.tolist(), sights(belief, cells, 4.0), strict=True):
        gain = view_gain(belief, divmod(cell, 20), 4.0)
        assert sum(int(bit_count(word)) for word in bits) == gain


def test_goals_are_spread() -> None:
    world = World(scenario("thesis-team-2"))
    world.begin(0, 0, floorplan=Floorplan.from_free(np.ones((1, 31), np.bool_), "corridor"), spawns=[(0, 15), (0, 16)])
    policy = make_policy("pso")
    pilots = [policy.pilot(world.briefing(0, k)) for k in range(2)]
    assert list(policy.act(pilots, [world.view(0, k) for k in range(2)])) == [1, 3]
