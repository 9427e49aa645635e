from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.planners.pomdp.policy import Window
from indoor_explorers.planners.toolbox.frontiers.clusters import frontier_clusters


@pytest.mark.parametrize("reach", [1, 4, 50])
def test_a_window_holds_what_is_around_a_cell(belief: Belief, start: Cell, reach: int) -> None:
    window = Window(belief, start, reach)
    at = int(window.flat(np.array([start[0] * belief.shape[1] + start[1]], np.int32))[0])
    assert window.belief.flat[at] == belief[start]
    rows, cols = (slice(max(0, place - reach), place + reach + 1) for place in start)
    assert np.array_equal(window.belief, belief[rows, cols])
    if reach == 50:
        clusters, inside = frontier_clusters(belief, 3.0), window.clusters(frontier_clusters(belief, 3.0))
        assert inside.cells.tolist() == clusters.cells.tolist()
        assert inside.ends.tolist() == clusters.ends.tolist()


def test_clusters_outside_of_a_window_are_empty() -> None:
    belief = np.zeros((1, 40), np.uint8)
    belief[0, 3:6] = belief[0, 30:33] = 1
    clusters = frontier_clusters(belief, 3.0)
    inside = Window(belief, (0, 4), 3).clusters(clusters)
    assert inside.size == clusters.size
    assert np.diff(inside.ends).sum() == 2
    assert set(inside.cells.tolist()) == {3 - 1, 5 - 1}
