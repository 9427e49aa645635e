from __future__ import annotations

import numpy as np

from indoor_explorers.env import Mate, Policy, World, scenario
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.policies.view import View
from indoor_explorers.planners.frontier.minpos import FrontierMinPos


def first_goal(policy: Policy, mates: tuple[Mate, ...]) -> tuple[int, int]:
    """The goal in a corridor, known from column 5 to 14, of the UAV in column 8."""
    world = World(scenario("thesis-team-2").with_settings({"radio.model": "disc", "radio.range": 4.0}))
    world.begin(0, 0, floorplan=Floorplan.from_free(np.ones((1, 20), np.bool_), "corridor"), spawns=[(0, 8), (0, 0)])
    belief = np.zeros((1, 20), np.uint8)
    belief[0, 5:15] = 1
    pilot = policy.pilot(world.briefing(0, 0))
    pilot.act(View(belief, (0, 8), np.ones(5, np.bool_), 100, 400, mates, np.zeros(belief.shape, np.bool_)))
    assert pilot.goal is not None  # type: ignore[attr-defined]
    return pilot.goal  # type: ignore[attr-defined,no-any-return]


def test_alone_it_takes_the_nearest() -> None:
    assert first_goal(FrontierMinPos(), ()) == (0, 5)


def test_it_leaves_a_frontier_to_the_mate_that_is_nearer() -> None:
    assert first_goal(FrontierMinPos(), (Mate(1, (0, 6), 0, None),)) == (0, 14)


def test_a_mate_on_the_other_side_changes_nothing() -> None:
    assert first_goal(FrontierMinPos(), (Mate(1, (0, 12), 0, None),)) == (0, 5)


def test_a_lost_mate_is_ignored() -> None:
    assert first_goal(FrontierMinPos(), (Mate(1, (0, 6), 2, None),)) == (0, 5)
    assert first_goal(FrontierMinPos(), (Mate(1, (0, 6), 61, None),)) == (0, 5)
    assert first_goal(FrontierMinPos(), (Mate(1, (0, 6), 20, None),)) == (0, 14)
