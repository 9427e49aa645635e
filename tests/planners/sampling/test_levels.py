"""Sampling on maps of several levels: segments, samples, trees and roadmaps in three dimensions, and whole flights."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from indoor_explorers.env import make_policy
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.levels import Levels, coordinates, plane_of
from indoor_explorers.planners.sampling.cover_tour import lattice
from indoor_explorers.planners.sampling.points import centre, known_cells, points_in
from indoor_explorers.planners.sampling.roadmaps import grow_roadmap
from indoor_explorers.planners.sampling.samples import border_cells, merged, tree_samples
from indoor_explorers.planners.sampling.segments import ALL_KNOWN, BLOCKED, entries, trace
from indoor_explorers.planners.sampling.trees import grow_tree
from tests.marks import slow
from tests.planners.flights import fly_preset

SHAPE = (4, 5, 6)
LEVELS = Levels(*SHAPE)


def some_volume(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.choice([UNKNOWN, FREE, OCCUPIED], SHAPE, p=[0.2, 0.7, 0.1]).astype(np.uint8)


def traced(plane, start, end):
    return trace(plane, *start[1:], *end[1:], LEVELS.rise, start[0], end[0])


def crossed(start: np.ndarray, end: np.ndarray) -> list[tuple[int, ...]]:
    """The cells of a volume that a segment crosses, in order: it is cut where it meets any border."""
    cuts = [
        (border - start[axis]) / (end[axis] - start[axis]) for axis in range(3) for border in range(SHAPE[axis] + 1)
    ]
    cuts = [0.0, *sorted(cut for cut in cuts if 0.0 < cut < 1.0), 1.0]
    middles = (np.add(cuts[:-1], cuts[1:]) / 2.0)[:, None]
    return [tuple(cell) for cell in np.floor(start + middles * (end - start)).astype(int).tolist()]


@pytest.mark.parametrize("seed", range(60))
def test_segments_agree_with_cuts_at_all_borders(seed):
    volume = some_volume(seed)
    start, end = np.random.default_rng(seed).random((2, 3)) * SHAPE
    cells = crossed(start, end)
    volume[cells[0]] = FREE
    values = [int(volume[cell]) for cell in cells]
    if OCCUPIED in values:
        expected = BLOCKED
    elif UNKNOWN in values:
        row, col = LEVELS.cell(cells[values.index(UNKNOWN) - 1])
        expected = row * LEVELS.width + col
    else:
        expected = ALL_KNOWN
    assert traced(plane_of(volume), start, end) == expected


def test_segments_on_one_level_of_several_are_those_of_a_plain_map():
    volume = some_volume(3)
    for points in np.random.default_rng(0).random((200, 2, 2)) * SHAPE[1:]:
        found = trace(plane_of(volume), *points.ravel(), LEVELS.rise, 2.5, 2.5)
        plain = trace(volume[2], *points.ravel())
        assert found == (plain + 2 * LEVELS.rise * LEVELS.width if plain >= 0 else plain)


@pytest.mark.parametrize("end", [(4.5, 0.5, 0.5), (-0.5, 0.5, 0.5), (0.5, 5.5, 0.5), (0.5, 0.5, 6.5)])
def test_leaving_the_volume_is_blocked(end: tuple[float, float, float]) -> None:
    assert traced(plane_of(np.full(SHAPE, FREE, np.uint8)), np.full(3, 0.5), np.array(end)) == BLOCKED


def test_points_and_cells_of_the_plane_belong_together():
    plane = plane_of(np.full(SHAPE, FREE, np.uint8))
    voxels = list(product(*map(range, SHAPE)))
    cells = np.array([row * LEVELS.width + col for row, col in map(LEVELS.cell, voxels)], np.int32)
    assert [tuple(voxel) for voxel in coordinates(cells, LEVELS.width, LEVELS.rise).tolist()] == voxels
    drawn = points_in(cells, LEVELS.width, LEVELS.rise, np.random.default_rng(0))
    assert known_cells(plane, drawn, LEVELS.rise).tolist() == cells.tolist()
    assert centre(LEVELS.cell((2, 1, 3)), LEVELS.rise) == (2.5, 1.5, 3.5)


@pytest.mark.parametrize("seed", range(4))
def test_border_cells_are_the_unknown_ones_with_a_free_one_among_six(seed: int) -> None:
    volume = some_volume(seed)
    low, high = np.array([1, 0, 2]), np.array([3, 4, 6])
    free = np.pad(volume == FREE, 1)
    near = np.zeros(SHAPE, bool)
    for axis, shift in product(range(3), (-1, 1)):
        near |= np.roll(free, shift, axis)[1:-1, 1:-1, 1:-1]
    voxels = np.argwhere((volume == UNKNOWN) & near)
    expected = voxels[((voxels >= low) & (voxels < high)).all(axis=1)]
    found = border_cells(plane_of(volume), low, high, LEVELS.rise)
    assert coordinates(found, LEVELS.width, LEVELS.rise).tolist() == expected.tolist()


def test_samples_fill_the_box_around_the_uav_within_the_volume() -> None:
    plane = plane_of(np.full(SHAPE, UNKNOWN, np.uint8))
    points = tree_samples(plane, LEVELS.cell((0, 2, 3)), 1.5, 500, 0.0, np.random.default_rng(0), LEVELS.rise)
    np.testing.assert_allclose(points.min(axis=0), (0.0, 1.0, 2.0), atol=0.05)
    np.testing.assert_allclose(points.max(axis=0), (2.0, 4.0, 5.0), atol=0.05)


def test_cells_are_merged_across_levels() -> None:
    voxels = [(0, 0, 0), (1, 0, 0), (2, 1, 0), (3, 0, 2)]
    cells = np.array([row * LEVELS.width + col for row, col in map(LEVELS.cell, voxels)], np.int32)
    assert merged(cells, 2.0, LEVELS.width, 9, LEVELS.rise).tolist() == [0, 2, 3]


def test_trees_climb_through_openings_and_no_slabs() -> None:
    volume = np.full(SHAPE, FREE, np.uint8)
    volume[1] = OCCUPIED
    plane, samples = plane_of(volume), np.random.default_rng(1).random((300, 3)) * SHAPE
    assert grow_tree(plane, (0.5, 0.5, 0.5), samples, 2.0, LEVELS.rise).vertices[:, 0].max() < 1.0
    volume[1, 4, 5], volume[3] = FREE, UNKNOWN
    plane = plane_of(volume)
    tree = grow_tree(plane, (0.5, 0.5, 0.5), np.concatenate([[(1.5, 4.5, 5.5)], samples] * 2), 2.0, LEVELS.rise)
    assert tree.vertices[:, 0].max() > 3.0
    for vertex, parent in zip(tree.vertices[1:], tree.parents[1:].tolist(), strict=True):
        assert np.linalg.norm(vertex - tree.vertices[parent]) <= 2.0 + 1e-9
        assert traced(plane, tree.vertices[parent], vertex) != BLOCKED
    found = coordinates(entries(plane, *tree, LEVELS.rise), LEVELS.width, LEVELS.rise)
    assert len(found) > 0
    assert set(found[:, 0].tolist()) == {2}


def test_roadmaps_join_levels_by_clear_edges() -> None:
    volume = some_volume(5)
    plane = plane_of(volume)
    free = np.flatnonzero(plane == FREE).astype(np.int32)
    points = points_in(free, LEVELS.width, LEVELS.rise, np.random.default_rng(0))
    roadmap = grow_roadmap(plane, points, LEVELS.rise)
    starts, ends = points[roadmap.edges[:, 0]], points[roadmap.edges[:, 1]]
    assert (np.floor(starts[:, 0]) != np.floor(ends[:, 0])).sum() > 20
    assert all(traced(plane, start, end) == ALL_KNOWN for start, end in zip(starts, ends, strict=True))


@pytest.mark.parametrize("apart", [1, 2, 3, 9])
def test_lattices_have_a_level_and_no_cells_between(apart: int) -> None:
    rows, cols = (np.arange(length) % apart == apart // 2 for length in SHAPE[1:])
    plain, found = np.logical_and.outer(rows, cols), lattice(LEVELS.shape, apart, LEVELS.rise)
    np.testing.assert_array_equal(lattice(SHAPE[1:], apart, 0), plain)
    assert not found[LEVELS.between].any()
    chosen = np.flatnonzero(LEVELS.volume(found).any(axis=(1, 2))).tolist()
    assert chosen == {1: [0, 1, 2, 3], 2: [1, 3], 3: [1], 9: [2]}[apart]
    for level in chosen:
        np.testing.assert_array_equal(LEVELS.volume(found)[level], plain)


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("rrt-frontier", {}),
        ("rrt-frontier", {"as_published": True}),
        ("rrt-nbv", {}),
        ("rrt-aep", {}),
        ("rrt-aep", {"take_turns": True}),
        ("rrt-predictive", {}),
        ("prm-tour", {}),
        ("cover-tour", {}),
    ],
)
@pytest.mark.parametrize("seed", [*slow(1), 2])
def test_planners_explore_all_storeys(name: str, settings: dict[str, bool], seed: int) -> None:
    team = {"team": 2, "radio.model": "disc", "radio.range": 8.0} if seed == 2 else {}
    world, _, _ = fly_preset(make_policy(name, **settings), "small-storeys", seed, **team)
    assert world.team_coverage[0] == 1.0
    assert not world.state.collisions.any()
