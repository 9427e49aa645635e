from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env.grid.cells import OCCUPIED, UNKNOWN
from indoor_explorers.env.search.bitsets import around, hash_keys, packed, unpacked
from indoor_explorers.env.search.optimistic_views import Sights
from indoor_explorers.planners.horizon import beam
from indoor_explorers.planners.horizon.beam import Style, Terrain, shortest_tour


def terrain_of(belief: np.ndarray, lidar: float, weights: np.ndarray) -> Terrain:
    sights = Sights(belief.shape, lidar)
    sights.update(belief)
    keys = hash_keys(2 * belief.size)
    return Terrain(sights.views, sights.passages, sights.soon, around(belief.shape), keys, weights)


def style(width: int, depth: int = 60, stretch: float = 0.0) -> Style:
    return Style(8.0, 0.02, stretch, width, depth)


def shortest(start: int, unseen: set[int], terrain: Terrain, size: int) -> int:
    """Breadth-first search over (cell, unseen set)."""
    views = [frozenset(np.flatnonzero(unpacked(bits, size)).tolist()) for bits in terrain.views]
    layer, met, steps = {(start, frozenset(unseen))}, {(start, frozenset(unseen))}, 0
    while all(rest for _, rest in layer):
        moves = {(n, rest - views[n]) for cell, rest in layer for n in terrain.passages[cell].tolist() if n >= 0}
        layer = moves - met
        met |= layer
        steps += 1
    return steps


@pytest.mark.parametrize("seed", range(6))
def test_a_wide_beam_finds_the_shortest_tour(seed: int) -> None:
    rng = np.random.default_rng(seed)
    belief = np.where(rng.random((5, 6)) < 0.15, OCCUPIED, UNKNOWN).astype(np.uint8)
    belief[0, 0] = belief[0, 1] = 1
    terrain = terrain_of(belief, 1.0, np.ones(30))
    sights = Sights(belief.shape, 1.0)
    sights.update(belief)
    unseen = packed(belief == UNKNOWN) & sights.attainable(0)
    members = set(np.flatnonzero(unpacked(unseen, 30)).tolist())
    tour, finishes = shortest_tour(0, unseen, terrain, 0.0, style(4000))
    assert finishes
    assert len(tour) == shortest(0, members, terrain, 30)
    for before, after in zip([0, *tour.tolist()], tour.tolist(), strict=False):
        assert after in terrain.passages[before]
        members -= set(np.flatnonzero(unpacked(terrain.views[after], 30)).tolist())
    assert not members


def worth(unseen: np.ndarray, weights: np.ndarray, isolation: float) -> float:
    """What is left to see by the formula in the module's docstring."""
    wide = np.pad(unseen.astype(int), 1)
    height, width = unseen.shape
    near = sum(wide[r : r + height, c : c + width] for r in range(3) for c in range(3)) - unseen
    return float((unseen * weights.reshape(unseen.shape) * (1 + isolation * (1 - near / 8))).sum())


@pytest.mark.parametrize("seed", range(4))
def test_states_are_ranked_by_the_formula(seed: int) -> None:
    rng = np.random.default_rng(seed)
    belief = np.where(rng.random((8, 9)) < 0.1, OCCUPIED, rng.integers(0, 2, (8, 9))).astype(np.uint8)
    belief[4, 4] = 1
    weights = rng.random(72)
    terrain = terrain_of(belief, 2.0, weights)
    states, children = beam._new_states(1, 2), beam._new_states(4, 2)
    beam._root(40, packed(belief == UNKNOWN), terrain, 8.0, states)
    found, _ = beam._expand(states, 1, terrain, style(1, stretch=0.5), -1.0, np.zeros(64, np.uint64), children)
    assert found == (terrain.passages[40] >= 0).sum()
    for k in range(found):
        seen = unpacked(terrain.views[children.cell[k]], 72).reshape(8, 9)
        unseen = (belief == UNKNOWN) & ~seen
        assert children.worth[k] == pytest.approx(worth(unseen, weights, 8.0))
        assert children.left[k] == pytest.approx(weights[unseen.ravel()].sum())
        assert np.array_equal(unpacked(children.unseen[k], 72), unseen.ravel())
        sooner = [not (packed(unseen) & terrain.soon[d, children.cell[k]]).any() for d in range(len(terrain.soon))]
        all_seen = [not (packed(unseen) & ~terrain.soon[d, children.cell[k]]).any() for d in range(len(terrain.soon))]
        steps = 0.02 * sum(sooner) + 0.5 * (len(all_seen) - sum(all_seen))
        assert children.rank[k] == pytest.approx(children.worth[k] + steps)


def test_a_tour_may_stop_before_everything_is_seen() -> None:
    belief = np.zeros((1, 20), np.uint8)
    belief[0, :2] = 1
    terrain = terrain_of(belief, 1.0, np.ones(20))
    unseen = packed(belief == UNKNOWN)
    assert shortest_tour(0, unseen, terrain, 0.0, style(10))[0].tolist() == list(range(1, 19))
    assert shortest_tour(0, unseen, terrain, 5.0, style(10))[0].tolist() == list(range(1, 14))
    tour, finishes = shortest_tour(0, unseen, terrain, 0.0, style(10, depth=4))
    assert tour.tolist() == [1, 2, 3, 4]
    assert not finishes
