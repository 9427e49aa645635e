"""Floors flown up to a decision for the pictures of planners, and the pilots that decide.

Evaluation imports no planner: pilots come from the registry, and the pictures read their attributes by name.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from indoor_explorers.env import View, World, make_policy, scenario
from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout

#: The offices of all pictures but one, and the floor of that, which is like those that the estimates were learned from.
OFFICE: dict[str, Any] = {"map.height": 22, "map.width": 32, "lidar.range": 6.0}
FLOOR: dict[str, Any] = {"map.height": 80, "map.width": 112, "map.area": [400.0, 2000.0]}
#: Seed of a floor and steps that were flown there before what is shown: for decisions, trees, estimates and swarm, and
#: for the flight in sectors.
DECISIONS, TREES, ESTIMATES, SWARM, SECTORS = (29, 81), (36, 81), (4, 426), (30, 69), (42, 60)


def flown(
    policy: str, place: tuple[int, int], settings: dict[str, Any], name: str = "small-offices"
) -> tuple[World, list[Any], list[list[Cell]]]:
    """Fly a team at a place, given by seed and steps; return the world, the pilots, and the cells of each UAV."""
    world = World(scenario(name).with_settings(settings))
    world.reset([place[0]])
    team = range(world.scenario.team)
    pilots = make_pilots(make_policy(policy), world)
    trails = [[world.view(0, uav).cell] for uav in team]
    for step, _ in enumerate(rollout(world, ask_pilots(make_policy(policy), pilots, world)), start=1):
        for uav in team:
            trails[uav].append(world.view(0, uav).cell)
        if step == place[1]:
            break
    return world, [pilots[0, uav] for uav in team], trails


@cache
def explored(place: tuple[int, int]) -> World:
    """Return a floor that one UAV has explored by flying to nearest frontiers."""
    settings, name = (FLOOR, "floors") if place == ESTIMATES else (OFFICE, "small-offices")
    return flown("frontier-nearest", place, settings | {"team": 1}, name)[0]


def pilot_at(policy: str, place: tuple[int, int]) -> tuple[Any, View]:
    """Return a pilot that has decided nothing yet, and the view that it decides from."""
    world = explored(place)
    return make_policy(policy).pilot(world.briefing(0, 0)), world.view(0, 0)


def cell_of(flat: Any, view: View) -> Cell:
    """Return the row and column of a flat cell."""
    row, col = divmod(int(flat), view.belief.shape[1])
    return row, col
