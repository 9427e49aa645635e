from __future__ import annotations

import networkx as nx
import numpy as np
import pytest

from indoor_explorers.env.grid.levels import Levels, plane_of
from indoor_explorers.planners.toolbox.frontiers.clusters import frontier_clusters
from indoor_explorers.planners.toolbox.pockets.features import (
    BESIDE,
    BLOCK,
    COARSE_LAYERS,
    FADE,
    FINE_LAYERS,
    LEVELS,
    NEAR,
    SIDE,
    pictures,
)

HALF = SIDE // 2


def padded(belief: np.ndarray, margin: int) -> np.ndarray:
    return np.pad(belief, margin, constant_values=2)


@pytest.mark.parametrize("shape", [(9, 9), (40, 61)])
def test_pictures_are_what_a_slow_drawing_shows(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(shape[0])
    coarse_map = rng.choice(np.array([0, 0, 1, 2], np.uint8), (shape[0] // 3 + 1, shape[1] // 3 + 1))
    belief = np.kron(coarse_map, np.ones((3, 3), np.uint8))[: shape[0], : shape[1]]
    clusters = frontier_clusters(belief, 5.0)
    seen = pictures(belief, clusters, 5.0)
    margin = (HALF + 1) * BLOCK
    around = padded(belief, margin)
    for k in range(clusters.size):
        cells = np.stack(np.divmod(clusters.cells[clusters.ends[k] : clusters.ends[k + 1]], shape[1]), axis=1)
        row, col = np.round(cells.mean(axis=0)).astype(int) + margin
        fine = around[row - HALF : row + HALF + 1, col - HALF : col + HALF + 1]
        for layer, value in ((0, 1), (1, 2), (3, 0)):
            assert (seen.fine[k, layer] == (fine == value)).all()
        own = {(r + margin - row + HALF, c + margin - col + HALF) for r, c in cells.tolist()}
        assert {(int(r), int(c)) for r, c in np.argwhere(seen.fine[k, 2])} == own
        side = SIDE * BLOCK
        large = around[row - side // 2 : row + side // 2 + 1, col - side // 2 : col + side // 2 + 1]
        for layer, value in enumerate((1, 2)):
            counts = (large == value).reshape(SIDE, BLOCK, SIDE, BLOCK).sum(axis=(1, 3))
            assert (seen.coarse[k, layer] == counts).all()
        assert seen.numbers[k] == pytest.approx([np.log1p(len(cells)) / 3, 0.5])


@pytest.mark.parametrize("size", [(4, 9, 11), (7, 20, 16)])
def test_pictures_over_levels_are_what_a_slow_drawing_shows(size: tuple[int, int, int]) -> None:
    """Each level is that of the padded volume; nearness is the way of networkx through the unknown voxels."""
    rng = np.random.default_rng(size[0])
    volume = rng.choice(np.array([0, 0, 1, 2], np.uint8), size)
    levels = Levels(*size)
    clusters = frontier_clusters(plane_of(volume), 4.0, levels.rise)
    seen = pictures(plane_of(volume), clusters, 4.0, levels.rise, 15.0)
    count, margin = 2 * BESIDE + 1, (HALF + 1) * BLOCK
    assert seen.fine.shape == (clusters.size, count * FINE_LAYERS, SIDE, SIDE)
    around = np.pad(volume, ((BESIDE, BESIDE), (margin, margin), (margin, margin)), constant_values=2)
    graph = nx.grid_graph((SIDE, SIDE, count))
    for k in range(clusters.size):
        flat = clusters.cells[clusters.ends[k] : clusters.ends[k + 1]]
        cells = levels.voxels(np.stack(np.divmod(flat, levels.width), axis=1))
        level, row, col = np.round(cells.mean(axis=0)).astype(int)
        shown = around[level : level + count]
        layers = seen.fine[k].reshape(count, FINE_LAYERS, SIDE, SIDE)
        top, left = row + margin - HALF, col + margin - HALF
        fine = shown[:, top : top + SIDE, left : left + SIDE]
        for layer, value in ((0, 1), (1, 2), (3, 0)):
            np.testing.assert_array_equal(layers[:, layer], fine == value)
        own = {tuple(voxel) for voxel in (cells - (level - BESIDE, row - HALF, col - HALF)).tolist()}
        assert {tuple(voxel) for voxel in np.argwhere(layers[:, 2]).tolist()} <= own
        assert layers[:, 2].sum() == sum(0 <= z < count and 0 <= r < SIDE and 0 <= c < SIDE for z, r, c in own)
        start = {voxel for voxel in own if voxel in graph}
        inside = graph.subgraph({tuple(voxel) for voxel in np.argwhere(fine == 0).tolist()} | start)
        expected = np.zeros_like(layers[:, 4])
        for voxel, steps in nx.multi_source_dijkstra_path_length(inside, start).items():
            expected[voxel] = int(255 * np.exp(-(steps - 1) / FADE)) if 0 < steps <= NEAR else 0
        np.testing.assert_array_equal(layers[:, 4], expected)
        side, half = SIDE * BLOCK, SIDE * BLOCK // 2
        large = shown[:, row + margin - half :, col + margin - half :][:, :side, :side]
        blocks = seen.coarse[k].reshape(count, COARSE_LAYERS, SIDE, SIDE)
        for layer, value in enumerate((1, 2)):
            counts = (large == value).reshape(count, SIDE, BLOCK, SIDE, BLOCK).sum(axis=(2, 4))
            np.testing.assert_array_equal(blocks[:, layer], counts)
        assert seen.numbers[k] == pytest.approx([np.log1p(len(cells)) / 3, 0.4, 15.0 / 90.0])
    assert seen.numbers.shape == (clusters.size, LEVELS.numbers)


def test_nearness_falls_with_the_way_through_the_unknown() -> None:
    belief = np.zeros((30, 30), np.uint8)
    belief[15, 3:16] = 1
    belief[14, 14] = 2
    clusters = frontier_clusters(belief, 2.0)
    seen = pictures(belief, clusters, 2.0)
    graph = nx.grid_2d_graph(SIDE, SIDE)
    for k in range(clusters.size):
        unknown, own = seen.fine[k, 3] == 1, [tuple(cell) for cell in np.argwhere(seen.fine[k, 2]).tolist()]
        inside = graph.subgraph([cell for cell in graph if unknown[cell]] + own)
        steps = nx.multi_source_dijkstra_path_length(inside, set(own))
        expected = np.zeros((SIDE, SIDE))
        for cell, d in steps.items():
            expected[cell] = int(255 * np.exp(-(d - 1) / FADE)) if 0 < d <= NEAR else 0
        np.testing.assert_array_equal(seen.fine[k, 4], expected)


def test_a_map_without_frontiers_has_no_pictures() -> None:
    belief = np.ones((5, 5), np.uint8)
    assert pictures(belief, frontier_clusters(belief, 3.0), 3.0).fine.shape == (0, 5, SIDE, SIDE)
