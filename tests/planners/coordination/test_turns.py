from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.planners.coordination.turns import left_over


def plain_left_over(
    worth: list[list[float]], points: list[list[float]], me: int, radius: float, taken: float
) -> list[float]:
    """What the function promises, in plain Python."""
    share = [1.0] * len(points)
    waiting = set(range(len(worth)))
    while True:
        best, i, k = max((worth[i][k] * share[k], -i, -k) for i in waiting for k in range(len(points)))
        if -i == me or best <= 0.0:
            return share
        waiting.remove(-i)
        for other, (row, col) in enumerate(points):
            away = ((row - points[-k][0]) ** 2 + (col - points[-k][1]) ** 2) ** 0.5
            share[other] = max(taken, share[other] * min(1.0, away / radius))


@pytest.mark.parametrize("seed", range(20))
def test_shares_are_those_of_a_plain_reference(seed: int) -> None:
    rng = np.random.default_rng(seed)
    uavs, clusters = int(rng.integers(1, 7)), int(rng.integers(1, 12))
    worth = rng.random((uavs, clusters)) * (rng.random((uavs, clusters)) < 0.8)
    points = rng.uniform(0, 30, (clusters, 2))
    for me in range(uavs):
        expected = plain_left_over(worth.tolist(), points.tolist(), me, 8.0, 0.01)
        assert left_over(worth, points, me, 8.0, 0.01) == pytest.approx(expected)


def test_nobody_takes_what_another_takes() -> None:
    worth = np.tile([4.0, 3.0, 2.0, 1.0], (4, 1))
    points = np.array([[0.0, 0.0], [0.0, 50.0], [50.0, 0.0], [50.0, 50.0]])
    chosen = [int((worth[me] * left_over(worth, points, me, 10.0, 0.01)).argmax()) for me in range(4)]
    assert chosen == [0, 1, 2, 3]


def test_a_single_cluster_is_left_to_all() -> None:
    share = left_over(np.array([[2.0], [1.0]]), np.zeros((1, 2)), 1, 5.0, 0.01)
    assert share == pytest.approx([0.01])
