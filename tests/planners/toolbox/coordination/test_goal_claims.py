from __future__ import annotations

import numpy as np

from indoor_explorers.env import World, scenario
from indoor_explorers.env.policies.view import Mate
from indoor_explorers.planners.toolbox.coordination.goal_claims import goals_near


def test_goals_of_linked_teammates_count_by_distance() -> None:
    world = World(scenario("thesis-team-4"))
    world.begin(0, 0)
    points = np.array([[2.0, 2.0], [2.0, 5.0], [9.0, 9.0]])
    mates = (
        Mate(1, (0, 0), 0, (2.0, 3.0)),
        Mate(2, (0, 1), 0, (2.0, 2.0, 0.5)),
        Mate(3, (9, 8), 1, (9.0, 9.0)),
    )
    view = world.view(0, 0)._replace(mates=mates)
    assert goals_near(view, points, 2.0).tolist() == [2, 1, 0]
    assert goals_near(view._replace(mates=(Mate(1, (0, 0), 0, None),)), points, 2.0).tolist() == [0, 0, 0]
