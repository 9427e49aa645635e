"""UAVs in contact share out the work: one does not fly after another while there is something else to do nearby."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from indoor_explorers.env import Policy, Scenario, View, World, make_policy
from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.planners.toolbox.coordination.sequence_chooser import not_taken
from indoor_explorers.planners.toolbox.frontiers.clusters import frontier_clusters, nearest_cells
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot
from tests.marks import slow
from tests.planners.flights import rooms

RANGE, RADIO = 3.0, 4.0
#: Goals of so few cells apart are the same.
SAME = 2.0


def decisions(policy: Policy, seed: int) -> Iterator[tuple[list[View], list[Cell | None]]]:
    """Fly two UAVs through a square of rooms; give what they know and where they fly to at each step."""
    settings = {"team": 2, "lidar.range": RANGE, "radio.model": "disc", "radio.range": RADIO}
    world = World(Scenario().with_settings({"map.source": "rooms", "budget": 2000, **settings}).for_evaluation())
    world.begin(0, seed, floorplan=Floorplan.from_free(rooms(4, 5, seed), "test"))
    pilots = [policy.pilot(world.briefing(0, agent)) for agent in range(2)]
    while world.flying.any():
        views = [world.view(0, agent) for agent in range(2)]
        actions = policy.act(pilots, views)
        yield views, [pilot.goal for pilot in pilots if isinstance(pilot, GoalPilot)]
        for agent, pilot in enumerate(pilots):
            world.post(0, agent, pilot.message)
        world.step(np.reshape(actions, (1, 2)))


def has_another(view: View, own: Cell, other: Cell) -> bool:
    """Tell whether there is a frontier cluster away from both goals, hardly farther from a UAV than its own goal."""
    field = distance_field(view.belief, view.cell)
    cells, steps = nearest_cells(field, frontier_clusters(view.belief, RANGE))
    rows, cols = np.divmod(cells, view.belief.shape[1])
    away = np.minimum(np.hypot(rows - own[0], cols - own[1]), np.hypot(rows - other[0], cols - other[1]))
    return bool(((away > 1.5 * RANGE) & (steps <= field[own] + 3.0 * RANGE)).any())


@pytest.mark.parametrize("name", ["frontier", "frontier-burgard", "frontier-hungarian", "pso", *slow("rrt")])
def test_linked_uavs_fly_to_different_places(name: str) -> None:
    policy, together, meetings = make_policy(name), [], 0
    for seed in range(1, 7):
        linked = True
        for views, goals in decisions(policy, seed):
            were, linked = linked, any(mate.age == 0 for mate in views[0].mates)
            meetings += linked and not were
            one, two = goals
            if linked and one and two and (has_another(views[0], one, two) or has_another(views[1], two, one)):
                together.append(float(np.hypot(one[0] - two[0], one[1] - two[1])) <= SAME)
    assert meetings >= 3
    assert len(together) >= 10
    assert np.mean(together) < 0.15


def test_a_first_place_counts_less_the_less_of_it_is_left() -> None:
    values, gains = np.array([3.0, 2.0, 0.0]), np.array([10.0, 10.0, 10.0])
    assert not_taken(values, np.array([5.0, 9.0, 9.0]), gains).tolist() == [3.0, 2.0, 0.0]
    assert not_taken(values, np.array([0.0, 2.5, 9.0]), gains).tolist() == [0.0, 2.0, 0.0]
    assert 0.0 < not_taken(values, np.array([1.0, 9.0, 9.0]), gains)[0] < 3.0
    assert not_taken(values, np.array([0.0, 0.0, 9.0]), gains).tolist() == [3.0, 2.0, 0.0]
