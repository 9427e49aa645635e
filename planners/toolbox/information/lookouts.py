"""Lookouts: viewpoints near a UAV that need not be at a frontier, each for a frontier cluster into which it sees.

On open floors a UAV sees what is behind tables and columns from where it passes, without a flight to each of them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.policies.view import View
from indoor_explorers.planners.toolbox.information.candidates import local_candidates
from indoor_explorers.planners.toolbox.information.cluster_places import ClusterPlaces, PlaceCells, log_gains
from indoor_explorers.planners.toolbox.information.view_gain import visible_sets
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot

#: Largest distance of a lookout from the UAV, in lidar ranges.
NEAR = 0.6
#: A viewpoint is left out if a better one sees this share of the unknown cells in its view.
SHARED = 0.5
#: Share of its gain that a lookout has to keep while the UAV flies there.
KEPT = 0.5


def with_lookouts(
    pilot: GoalPilot, places: ClusterPlaces, view: View, found: PlaceCells, discount_rate: float, most: int
) -> PlaceCells:
    """Return possible viewpoints with lookouts among them.

    Args:
        pilot: The pilot that flies to them.
        places: Finds its viewpoints.
        view: What its UAV knows.
        found: The L viewpoints on frontiers.
        discount_rate: Discount rate of view gains per lidar range of distance.
        most: Most lookouts, those with the largest discounted gains.

    """
    rate = discount_rate / pilot.briefing.lidar_range
    scores = log_gains(places.views(view, found.cells)) - rate * found.steps
    best = places.best_of_each(found.owner, scores, np.zeros(len(scores), np.bool_))
    field = pilot.steps_from(view, view.cell)
    near = local_candidates(view.belief, field[None], pilot.lidar, pilot.steps_in(NEAR), rate, most)
    near = near[~view.visited.ravel()[near] & ~pilot.near_banned(view, near) & ~np.isin(near, found.cells)]
    if not len(near):
        return found
    sets = visible_sets(view.belief, np.concatenate([found.cells[best], near]), pilot.lidar)
    shared = np.bitwise_count(sets[len(best) :, None] & sets[None, : len(best)]).sum(axis=2)
    chosen = shared.max(axis=1) > 0
    near, owner = near[chosen], found.owner[best[shared[chosen].argmax(axis=1)]]
    return found._replace(
        cells=np.concatenate([found.cells, near]),
        owner=np.concatenate([found.owner, owner]),
        steps=np.concatenate([found.steps, field.ravel()[near]]),
    )


def distinct(pilot: GoalPilot, view: View, cells: NDArray[np.int32]) -> Mask:
    """Return which of (K,) viewpoints, the best one first, no better one makes superfluous, (K,) bool."""
    sets = visible_sets(view.belief, cells, pilot.lidar)
    sizes = np.bitwise_count(sets).sum(axis=1)
    kept = np.ones(len(cells), np.bool_)
    for k in range(1, len(cells)):
        shared = np.bitwise_count(sets[:k][kept[:k]] & sets[k]).sum(axis=1)
        kept[k] = (shared < SHARED * max(1, sizes[k])).all()
    return kept
