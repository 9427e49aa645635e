from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env.grid import distance_field
from indoor_explorers.planners.clusters import frontier_clusters
from indoor_explorers.planners.coordination.places import means, near_goal, sizes, steps_to


@pytest.mark.parametrize("seed", range(5))
def test_places_are_those_of_a_plain_reference(seed: int) -> None:
    rng = np.random.default_rng(seed)
    belief = rng.choice(np.array([0, 1, 2], np.uint8), (17, 23), p=[0.15, 0.7, 0.15])
    clusters = frontier_clusters(belief, 5.0)
    field = distance_field(belief, (8, 8))
    goal = (9, 12)
    for k in range(clusters.size):
        cells = [divmod(int(cell), 23) for cell in clusters.cells[clusters.ends[k] : clusters.ends[k + 1]]]
        assert sizes(clusters)[k] == len(cells)
        assert means(clusters, 23)[k] == pytest.approx(np.mean(cells, axis=0))
        assert steps_to(clusters, field)[k] == min(field[cell] for cell in cells)
        near = any((row - goal[0]) ** 2 + (col - goal[1]) ** 2 <= 9.0 for row, col in cells)
        assert bool(near_goal(clusters, goal, 3.0, 23)[k]) is near
