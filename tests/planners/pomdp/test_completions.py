from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.planners.pomdp.completions import completions, pocket_sizes, strata
from indoor_explorers.planners.toolbox.frontiers.clusters import frontier_clusters
from indoor_explorers.planners.toolbox.pockets.network import THRESHOLDS


def corridor() -> Belief:
    """Three known cells in the middle of an unknown corridor: a cluster at each end."""
    belief = np.full((1, 21), UNKNOWN, np.uint8)
    belief[0, 9:12] = FREE
    return belief


def tail(more_than: int, probability: float) -> list[float]:
    return [probability if size < more_than else 0.0 for size in THRESHOLDS]


def test_sizes_are_quantiles_of_the_estimates() -> None:
    tails = np.array([[0.5] * len(THRESHOLDS), tail(8, 0.25), tail(3, 1.0)])
    sizes = pocket_sizes(tails, np.array([0.1, 0.3, 0.7]))
    assert sizes[0, 0] > THRESHOLDS[-1]
    assert 6 < sizes[0, 1] <= 8
    assert sizes[1:, 1].tolist() == [0, 0]
    assert sizes[2].tolist() == [0, 0, 3]


def test_sizes_are_scaled_and_agree_with_the_tails() -> None:
    rng = np.random.default_rng(0)
    tails = np.sort(rng.random((3, len(THRESHOLDS))), axis=1)[:, ::-1].copy()
    quantiles = strata(2000, rng)
    sizes = pocket_sizes(tails, quantiles)
    for at, threshold in enumerate(THRESHOLDS):
        assert (sizes > threshold).mean(axis=0) == pytest.approx(tails[:, at], abs=2e-3)
    assert (pocket_sizes(tails, quantiles, 3.0) >= sizes).all()


def test_strata_cover_all_quantiles() -> None:
    drawn = strata(10, np.random.default_rng(3))
    assert np.floor(np.sort(drawn) * 10).tolist() == list(range(10))


def test_pockets_grow_from_their_clusters_to_their_sizes() -> None:
    belief = corridor()
    clusters = frontier_clusters(belief, 2.0)
    assert clusters.size == 2
    drawn = completions(belief, clusters, np.array([[3, 1], [0, 2], [50, 50]]))
    rows = ["".join("?.#"[cell] for cell in completion[0]) for completion in drawn.maps]
    assert rows == ["######.......########", "#########.....#######", "." * 21]
    assert drawn.owners[0].tolist() == [-1] * 6 + [0] * 3 + [-1] * 3 + [1] + [-1] * 8
    assert (drawn.owners[2] >= 0).sum() == 18


def test_completions_agree_with_the_belief(belief: Belief) -> None:
    clusters = frontier_clusters(belief, 3.0)
    sizes = np.random.default_rng(1).integers(0, 30, (4, clusters.size))
    drawn = completions(belief, clusters, sizes)
    known = belief != UNKNOWN
    for completion, owners, size in zip(drawn.maps, drawn.owners, sizes, strict=True):
        assert np.array_equal(completion[known], belief[known])
        assert set(np.unique(completion)) <= {FREE, OCCUPIED}
        grown = np.bincount(owners[owners >= 0], minlength=clusters.size)
        assert (grown <= size).all()
        assert np.array_equal(owners.reshape(belief.shape) >= 0, (completion == FREE) & ~known)
