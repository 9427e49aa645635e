"""Coarser maps: areas are conserved, doors stay open, walls stay closed, and what was lost is reported."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from indoor_explorers.env import InputError
from indoor_explorers.env.grid.arrays import Belief, Mask
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.maps.reduction import Source, area_share, cropped, reduced
from indoor_explorers.env.search.connected_parts import connected_parts


def source(cells: Belief, resolution: float = 0.1) -> Source:
    return Source(name="plan", where="plan.yaml", cells=cells, resolution=resolution)


def rooms(rows: int, cols: int, *, side: int, wall: int, door: int) -> Belief:
    """A grid of square rooms with walls of ``wall`` and doors of ``door`` pixels between neighbours."""
    pitch = side + wall
    plan = np.full((rows * pitch + wall, cols * pitch + wall), FREE, np.uint8)
    for k in range(wall):
        plan[k::pitch] = OCCUPIED
        plan[:, k::pitch] = OCCUPIED
    middle = wall + (side - door) // 2
    for r in range(rows):
        for c in range(cols):
            top, left = r * pitch, c * pitch
            if c:
                plan[top + middle : top + middle + door, left : left + wall] = FREE
            if r:
                plan[top : top + wall, left + middle : left + middle + door] = FREE
    return plan


def brute_force(mask: Mask, factor: float) -> NDArray[np.float64]:
    """The share of every cell's area, pixel by pixel."""
    shape = tuple(math.ceil(side / factor - 1e-9) for side in mask.shape)
    out = np.zeros(shape)
    for row, col in np.argwhere(mask).tolist():
        for i in range(shape[0]):
            for j in range(shape[1]):
                tall = min((i + 1) * factor, row + 1) - max(i * factor, row)
                wide = min((j + 1) * factor, col + 1) - max(j * factor, col)
                out[i, j] += max(tall, 0.0) * max(wide, 0.0) / factor**2
    return out


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32), st.integers(1, 12), st.integers(1, 12), st.sampled_from([1.0, 2.0, 3.0, 1.5, 2.3, 7.9]))
def test_area_shares_equal_brute_force(seed: int, height: int, width: int, factor: float) -> None:
    mask = np.random.default_rng(seed).random((height, width)) < 0.5
    np.testing.assert_allclose(area_share(mask, factor), brute_force(mask, factor), atol=1e-9)


@pytest.mark.parametrize("factor", [2.0, 5.0, 3.7, 1.0001])
def test_area_is_conserved_on_large_maps(factor: float) -> None:
    mask = np.random.default_rng(0).random((500, 333)) < 0.3
    assert area_share(mask, factor).sum() * factor**2 == pytest.approx(mask.sum())


def test_without_a_resolution_or_with_the_source_s_nothing_is_resampled() -> None:
    plan = rooms(2, 2, side=9, wall=1, door=3)
    for resolution in (None, 0.1, 0.1000000001):
        assert reduced(source(plan), resolution).truth.tolist() == plan.tolist()


@pytest.mark.parametrize("wall", [1, 2, 3])
@pytest.mark.parametrize("factor", [2, 3, 4, 5, 2.5, 3.3, 4.7])
def test_doors_stay_open_and_walls_stay_closed(wall: int, factor: float) -> None:
    """Doors of 0.9 m between rooms of 4.1 m, walls from one pixel (0.1 m): one connected floor, rooms apart."""
    plan = rooms(3, 4, side=41, wall=wall, door=9)
    coarse = reduced(source(plan), 0.1 * factor)
    assert coarse.kept > 0.95
    free = coarse.truth == FREE
    for r in range(1, 3):
        crossings = free[crossed(r * (41 + wall), wall, factor)].all(axis=0)
        assert 4 <= crossings.sum() <= 4 * 9 / factor, "each of the four doors of a wall is open, and nothing else"
        assert connected_parts(crossings[None, :])[0].max() == 4


def crossed(start: int, wall: int, factor: float) -> slice:
    """The rows of cells that a wall of pixels from ``start`` on lies in."""
    return slice(int(start / factor + 1e-9), math.ceil((start + wall) / factor - 1e-9))


@pytest.mark.parametrize("factor", [2, 3.7, 5])
def test_a_slanted_wall_of_single_pixels_does_not_leak(factor: float) -> None:
    """The smaller side of a wall without any door is not joined to the larger one."""
    plan = np.full((120, 120), FREE, np.uint8)
    columns = np.arange(120)
    plan[(20 + columns * 0.37).astype(int), columns] = OCCUPIED
    free = reduced(source(plan), 0.1 * factor).truth == FREE
    assert not free[0].any()
    assert free[-3, :-1].all()


def test_lost_rooms_are_reported() -> None:
    """A door that takes a small part of its cell's width closes, and with it a third of the floor."""
    plan = np.full((40, 70), FREE, np.uint8)
    plan[:, 40:50] = OCCUPIED
    plan[22:25, 40:50] = FREE
    coarse = reduced(source(plan), 1.0)
    assert coarse.kept == pytest.approx(40 / 60, abs=0.03)
    assert (coarse.truth[:, 4:] == OCCUPIED).all()


def test_of_two_separate_floors_the_larger_one_stays() -> None:
    plan = np.full((20, 40), OCCUPIED, np.uint8)
    plan[:, :10], plan[:, 30:35] = FREE, FREE
    for resolution in (None, 0.5):
        coarse = reduced(source(plan), resolution)
        assert coarse.kept == pytest.approx(2 / 3)
        assert (coarse.truth[:, coarse.shape[1] // 2 :] == OCCUPIED).all()


def test_unknown_counts_as_solid() -> None:
    plan = np.full((20, 20), UNKNOWN, np.uint8)
    plan[:, :8] = FREE
    assert (reduced(source(plan), None).truth[:, 8:] == OCCUPIED).all()
    assert (reduced(source(plan), 0.5).truth == FREE).sum(axis=1).tolist() == [2] * 4


def test_cropping_keeps_every_free_cell() -> None:
    plan = np.full((20, 20), OCCUPIED, np.uint8)
    plan[5:9, 0:3] = FREE
    small = cropped(reduced(source(plan), None))
    assert small.shape == (6, 5)
    assert (small.truth == FREE).sum() == 12


@pytest.mark.parametrize(
    ("resolution", "message"),
    [
        (0.05, "expected a resolution of at least the source's 0.1 m, got 0.05 m"),
        (0.0, "expected a resolution above 0 m"),
        (-1.0, "expected a resolution above 0 m"),
        (math.nan, "expected a resolution above 0 m"),
        (math.inf, "expected a resolution above 0 m"),
        (50.0, "expected cells smaller than the map"),
    ],
)
def test_impossible_resolutions_are_refused(resolution: float, message: str) -> None:
    with pytest.raises(InputError, match=f"plan.yaml: {message}"):
        reduced(source(np.full((20, 20), FREE, np.uint8)), resolution)


@pytest.mark.parametrize("factor", [None, 0.2])
def test_more_cells_than_a_map_may_have_are_refused_before_any_work(factor: float | None) -> None:
    with pytest.raises(InputError, match=r"plan.yaml: expected at most 4,194,304 cells, got .*coarser --resolution"):
        reduced(source(np.zeros((6_000, 6_000), np.uint8)), factor)


def test_a_largest_map_without_walls_gets_none() -> None:
    open_ = replace(source(np.full((2048, 2048), FREE, np.uint8)), start=(0, 7))
    plan = cropped(reduced(open_, None))
    assert (plan.shape, plan.start) == ((2048, 2048), (0, 7))
    assert (plan.truth == FREE).all()


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**32), st.sampled_from([None, 0.2, 0.25, 0.37]))
def test_a_start_becomes_the_nearest_free_cell_of_the_map(seed: int, resolution: float | None) -> None:
    rng = np.random.default_rng(seed)
    plan = np.where(rng.random((30, 41)) < 0.2, OCCUPIED, FREE).astype(np.uint8)
    start = int(rng.integers(30)), int(rng.integers(41))
    coarse = reduced(replace(source(plan), start=start), resolution)
    assert coarse.start is not None
    wanted = np.array(start) // (1.0 if resolution is None else resolution / 0.1)
    distances = ((np.argwhere(coarse.truth == FREE) - wanted) ** 2).sum(axis=1)
    assert ((np.array(coarse.start) - wanted) ** 2).sum() == distances.min()
    small = cropped(coarse)
    assert small.start is not None
    assert small.truth[small.start] == FREE
    row, col = (int(np.flatnonzero(free)[0]) for free in ((coarse.truth == FREE).any(1), (coarse.truth == FREE).any(0)))
    assert small.start == (coarse.start[0] - row + 1, coarse.start[1] - col + 1)


@pytest.mark.parametrize("resolution", [None, 0.2, 0.37])
def test_the_largest_map_is_reduced_and_keeps_its_corridors(resolution: float | None) -> None:
    """2048 x 2048 pixels: a grid of rooms with doors; at its own resolution also corridors of a single cell."""
    plan = rooms(50, 50, side=38, wall=2, door=9)[:2048, :2048]
    plan = np.pad(plan, [(0, 2048 - side) for side in plan.shape], constant_values=OCCUPIED)
    coarse = reduced(source(plan), resolution)
    assert coarse.kept > 0.99


def test_a_single_corridor_up_and_down_the_largest_map_is_kept() -> None:
    line = np.full((2048, 2048), OCCUPIED, np.uint8)
    line[1:-1:2, 1:-1] = FREE
    line[2:-2:4, -2] = line[4:-2:4, 1] = FREE
    snake = cropped(reduced(replace(source(line), start=(2, 5)), None))
    assert snake.kept == 1.0
    assert snake.shape == (2047, 2048)
    assert snake.start == (1, 5)


def test_a_floor_too_narrow_for_its_cells_is_refused() -> None:
    plan = np.full((20, 20), OCCUPIED, np.uint8)
    plan[10] = FREE
    with pytest.raises(InputError, match=r"expected some floor left.*finer one \(the source has 0.1 m\)"):
        reduced(source(plan), 1.0)


def test_a_map_without_floor_is_refused() -> None:
    with pytest.raises(InputError, match="expected a map with free pixels, got none; check its values, or thresholds"):
        reduced(source(np.full((5, 5), UNKNOWN, np.uint8)), None)
