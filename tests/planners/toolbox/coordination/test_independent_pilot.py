from __future__ import annotations

import numpy as np

from indoor_explorers.env import World, scenario
from indoor_explorers.env.policies.view import Mate
from indoor_explorers.planners.swarm.gso import GlowwormPilot, Gso


def test_gains_near_goals_of_linked_teammates_are_dimmed_by_each() -> None:
    world = World(scenario("thesis-team-4").with_settings({"lidar.range": 2.0}))
    world.begin(0, 0)
    pilot, cells = GlowwormPilot(world.briefing(0, 0), Gso()), np.array([2 * 16 + 2, 2 * 16 + 5, 9 * 16 + 9], np.int32)
    mates = (
        Mate(1, (0, 0), 0, (2.0, 3.0)),
        Mate(2, (0, 1), 0, (2.0, 2.0, 0.5)),
        Mate(3, (9, 8), 1, (9.0, 9.0)),
    )
    view = world.view(0, 0)._replace(mates=mates)
    assert pilot.not_dimmed(view, cells, 0.5).tolist() == [0.25, 0.5, 1.0]
    assert pilot.not_dimmed(view._replace(mates=(Mate(1, (0, 0), 0, None),)), cells, 0.5).tolist() == [1.0, 1.0, 1.0]
