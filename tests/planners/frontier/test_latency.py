from __future__ import annotations

import numpy as np

from indoor_explorers.env import Mate, World, make_policy, scenario
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.policies.view import View
from indoor_explorers.planners.frontier.latency import FrontierLatency, LatencyPilot
from tests.planners.flights import fly, rooms


def test_it_needs_fewer_steps_than_the_nearest_frontier() -> None:
    halls = [rooms(3, 9, seed) for seed in range(4)]
    maps = [*halls, *(np.ones((16, 16), np.bool_),) * 4]
    steps = {
        name: [fly(make_policy(name), free, seed=seed).steps for seed, free in enumerate(maps)]
        for name in ("frontier-latency", "frontier-nearest")
    }
    assert sum(steps["frontier-latency"]) < 0.95 * sum(steps["frontier-nearest"])


def corridor(mates: tuple[Mate, ...]) -> tuple[LatencyPilot, View]:
    """A UAV in column 8 of a corridor of which the columns 5 to 14 are known."""
    world = World(scenario("thesis-team-2").with_settings({"radio.model": "disc", "radio.range": 4.0}))
    world.begin(0, 0, floorplan=Floorplan.from_free(np.ones((1, 20), np.bool_), "corridor"), spawns=[(0, 8), (0, 0)])
    belief = np.zeros((1, 20), np.uint8)
    belief[0, 5:15] = 1
    view = View(belief, (0, 8), np.ones(5, np.bool_), 100, 400, mates, np.zeros(belief.shape, np.bool_))
    return LatencyPilot(world.briefing(0, 0), FrontierLatency()), view


def test_it_leaves_a_frontier_to_the_mate_that_is_nearer() -> None:
    for mates, goal in [((), (0, 5)), ((Mate(1, (0, 6), 0, None),), (0, 14))]:
        pilot, view = corridor(mates)
        assert pilot.choose(view) == goal


def test_every_mate_that_is_nearer_halves_a_gain() -> None:
    pilot, view = corridor((Mate(1, (0, 6), 0, None),))
    cells, steps = np.array([5, 14], np.int32), np.array([3, 6], np.int32)
    assert pilot.factors(view, cells, steps).tolist() == [0.5, 1.0]
