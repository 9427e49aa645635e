"""Pockets: what is unknown behind the frontiers while a UAV explores a map, as the pocket network learns it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import Scenario, World, make_policy
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.env.simulation.rollout import Uav, ask_pilots, make_pilots, rollout
from indoor_explorers.planners.toolbox.frontiers.clusters import frontier_clusters
from indoor_explorers.planners.toolbox.pockets.labels import true_pockets

#: The policy that flies, and steps from one look at its frontiers to the next.
POLICY, EVERY = "frontier-nearest", 25


class Frontiers(NamedTuple):
    """What the looks of one flight found."""

    pockets: NDArray[np.float64]
    """(K,) unknown free cells behind each frontier cluster of each look, see
    :func:`~indoor_explorers.planners.toolbox.pockets.labels.true_pockets`."""
    clusters: NDArray[np.float64]
    """(L,) frontier clusters of each look."""


def fly(plan: Floorplan, scenario: Scenario, seed: int) -> Frontiers:
    """Explore a map to the end with one UAV that has the scenario's lidar, and look at its frontiers now and then."""
    world = World(scenario.with_settings({"team": 1, "spawn": "random", "budget": None}).for_evaluation())
    world.begin(0, seed, floorplan=plan)
    policy = make_policy(POLICY)
    asks = ask_pilots(policy, make_pilots(policy, world), world)
    looks: list[NDArray[np.float64]] = []

    def look_and_ask(flying: list[Uav]) -> Iterable[tuple[Uav, int]]:
        view = world.view(0, 0)
        if view.step % EVERY == 0:
            clusters = frontier_clusters(view.belief, scenario.lidar.range)
            looks.append(true_pockets(view.belief, plan.truth, distance_field(view.belief, view.cell), clusters).sizes)
        return asks(flying)

    for _ in rollout(world, look_and_ask):
        pass
    return Frontiers(np.concatenate([np.zeros(0), *looks]), np.array([float(len(look)) for look in looks]))
