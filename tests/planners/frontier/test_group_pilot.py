from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from indoor_explorers.env import Mate, Policy
from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.planners.frontier.burgard import FrontierBurgard
from indoor_explorers.planners.frontier.group_pilot import GroupPilot
from indoor_explorers.planners.frontier.hungarian import FrontierHungarian
from indoor_explorers.planners.frontier.minpos import FrontierMinPos
from indoor_explorers.planners.frontier.tour import FrontierTour
from indoor_explorers.planners.frontier.utility import FrontierUtility
from tests.planners.flights import view_of, world_on

POLICIES = [FrontierBurgard(), FrontierHungarian(), FrontierTour(), FrontierUtility(), FrontierMinPos()]


def pilot_of(policy: Policy, agent: int, shape: tuple[int, int], team: int = 2) -> Any:
    """A pilot of a team that is linked within four cells."""
    spawns = [(0, col) for col in range(team)]
    world = world_on(np.ones(shape, np.bool_), spawns, team=team, radio__model="disc", radio__range=4.0)
    return policy.pilot(world.briefing(0, agent))


def corridor(first: int = 5, last: int = 14) -> np.ndarray:
    """A corridor of 20 cells, known from ``first`` to ``last``."""
    belief = np.zeros((1, 20), np.uint8)
    belief[0, first : last + 1] = 1
    return belief


@pytest.fixture(params=POLICIES, ids=lambda policy: type(policy).__name__)
def policy(request: pytest.FixtureRequest) -> Any:
    return request.param


def test_alone_it_takes_the_nearer_end(policy: Policy) -> None:
    pilot = pilot_of(policy, 0, (1, 20))
    pilot.act(view_of(corridor(), (0, 8)))
    assert pilot.goal == (0, 5)
    assert pilot.message == ((0.0, 5.0) if isinstance(pilot, GroupPilot) else None)


@pytest.mark.parametrize("cells", [((0, 8), (0, 9)), ((0, 6), (0, 7)), ((0, 12), (0, 7)), ((0, 9), (0, 8))])
def test_linked_uavs_take_different_ends(policy: Policy, cells: tuple[Cell, Cell]) -> None:
    goals = []
    for agent in (0, 1):
        pilot = pilot_of(policy, agent, (1, 20))
        pilot.act(view_of(corridor(), cells[agent], (Mate(1 - agent, cells[1 - agent], 0, None),)))
        goals.append(pilot.goal)
    assert sorted(goals) == [(0, 5), (0, 14)]


def test_a_mate_that_should_be_heard_and_is_not_changes_nothing(policy: Policy) -> None:
    for age in (2, 61):
        pilot = pilot_of(policy, 0, (1, 20))
        pilot.act(view_of(corridor(), (0, 8), (Mate(1, (0, 6), age, (0.0, 5.0)),)))
        assert pilot.goal == (0, 5)


def test_a_silent_mate_that_may_fly_on_keeps_its_end(policy: Policy) -> None:
    pilot = pilot_of(policy, 0, (1, 20))
    pilot.act(view_of(corridor(), (0, 8), (Mate(1, (0, 6), 20, None),)))
    assert pilot.goal == (0, 14)


def test_more_uavs_than_clusters_all_get_a_goal(policy: Policy) -> None:
    cells = [(0, 6), (0, 7), (0, 8), (0, 9), (0, 10)]
    goals = []
    for agent, cell in enumerate(cells):
        pilot = pilot_of(policy, agent, (1, 20), team=5)
        mates = tuple(Mate(k, other, 0, None) for k, other in enumerate(cells) if k != agent)
        pilot.act(view_of(corridor(), cell, mates))
        goals.append(pilot.goal)
    assert set(goals) == {(0, 5), (0, 14)}


def test_a_goal_is_held_on_to(policy: Policy) -> None:
    pilot = pilot_of(policy, 0, (1, 20))
    pilot.act(view_of(corridor(), (0, 9)))
    assert pilot.goal == (0, 5)
    longer = corridor(last=13)
    longer[0, 13] = 2
    longer[0, 3:5] = 1
    pilot.act(view_of(longer, (0, 8), step=101))
    assert pilot.goal == (0, 3)


def test_nothing_in_reach_is_no_goal(policy: Policy) -> None:
    belief = corridor()
    belief[0, [6, 10]] = 2
    pilot = pilot_of(policy, 0, (1, 20))
    assert pilot.act(view_of(belief, (0, 8))) == 4
    assert (pilot.goal, pilot.message) == (None, None)


def test_choices_are_what_everybody_could_fly_to() -> None:
    pilot = pilot_of(FrontierHungarian(), 0, (1, 20))
    belief = corridor()
    belief[0, 11] = 2
    mate = Mate(1, (0, 13), 0, (0.0, 14.0))
    view = view_of(belief, (0, 8), (mate,))
    pilot.navigator.goal = (0, 5)
    choices = pilot.choices(view, pilot.members(view))
    assert choices.me == 0
    assert choices.viewpoints().tolist() == [14, 5]
    assert choices.steps.tolist() == [[UNREACHABLE, 3], [1, UNREACHABLE]]
    assert choices.held.tolist() == [[False, True], [True, False]]
    assert choices.costs(2.0)[1].tolist() == [-1.0, UNREACHABLE]
