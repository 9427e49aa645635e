"""View gains: the unknown cells that a scan could reveal, on a belief map whose unknown cells count as transparent."""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import UNKNOWN
from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.grid.levels import offset, on_level, rise_of
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.sensing.lidar import LidarModel, Scan, model_of, new_scan, newly_visible_cells


@kernel()
def _unclaimed(
    belief: np.ndarray, cells: np.ndarray, claims: np.ndarray, radius: float, lidar: LidarModel
) -> np.ndarray:
    width, rise = belief.shape[1], rise_of(belief.shape[0], lidar.volume.levels)
    scan = new_scan(lidar)
    gains = np.zeros(cells.shape[0], np.int64)
    for k in range(cells.shape[0]):
        for place in range(newly_visible_cells(belief, belief, cells[k] // width, cells[k] % width, lidar, scan)):
            row, col = divmod(scan.cells[place], width)
            counts = belief[row, col] == UNKNOWN
            for m in range(claims.shape[0]):
                levels, rows, cols = offset(int(claims[m, 0]), int(claims[m, 1]), row, col, rise)
                counts &= levels * levels + rows * rows + cols * cols > radius * radius
            gains[k] += counts
    return gains


def unclaimed_gains(
    belief: Belief, cells: NDArray[np.int32], claims: NDArray[np.float64], lidar_range: LidarModel | float
) -> NDArray[np.int64]:
    """Return the number of unknown cells that are visible from each of (K,) flat cells and not claimed, (K,).

    ``claims`` is (M, 2) rows and columns of other UAVs' goals; cells within the lidar range of one are claimed. The
    lidar is given as such or by its range.
    """
    lidar = model_of(lidar_range)
    return np.asarray(_unclaimed(belief, cells, claims, lidar.range, lidar))


@kernel()
def _visible_sets(belief: np.ndarray, cells: np.ndarray, lidar: LidarModel) -> np.ndarray:
    width = belief.shape[1]
    scan = new_scan(lidar)
    number = np.full(belief.size, -1, np.int64)
    lists = np.empty((cells.shape[0], lidar.disc + 1), np.int64)
    sizes = np.zeros(cells.shape[0], np.int64)
    total = 0
    for k in range(cells.shape[0]):
        for place in range(newly_visible_cells(belief, belief, cells[k] // width, cells[k] % width, lidar, scan)):
            cell = scan.cells[place]
            if belief[cell // width, cell % width] == UNKNOWN:
                if number[cell] < 0:
                    number[cell] = total
                    total += 1
                lists[k, sizes[k]] = number[cell]
                sizes[k] += 1
    bits = np.zeros((cells.shape[0], (total + 63) // 64), np.uint64)
    for k in range(cells.shape[0]):
        for place in range(sizes[k]):
            bits[k, lists[k, place] // 64] |= np.uint64(1) << np.uint64(lists[k, place] % 64)
    return bits


def visible_sets(belief: Belief, cells: NDArray[np.int32], lidar_range: LidarModel | float) -> NDArray[np.uint64]:
    """Return the sets of unknown cells visible from each of (K,) flat cells as bit sets, (K, words) uint64.

    Unknown cells are numbered in the order in which they are found; the bitwise or of sets is a joint view.
    """
    return np.asarray(_visible_sets(belief, cells, model_of(lidar_range)))


#: Half width of the square around an unknown cell in which known cells make it isolated.
NEIGHBOURHOOD = 2
#: Number of other cells in that square.
AROUND = (2 * NEIGHBOURHOOD + 1) ** 2 - 1
#: Side in cells of the tiles that changes are boxed in; with teammates the map changes in several places at once.
TILE = 16
#: Mark of a gain that has to be computed.
STALE = -1.0


@leaf(entry=False)
def known_around(belief: np.ndarray, row: int, col: int, rise: int) -> float:
    """Count the cells around an unknown one of a (H, W) belief that are known or off the map, at most ``AROUND``.

    Over several levels those of the cube around it are counted, and the number is scaled to the same maximum.
    """
    levels, height = ((belief.shape[0] + 1) // rise, rise - 1) if rise > 0 else (1, belief.shape[0])
    (level, at), up = on_level(row, rise), NEIGHBOURHOOD if rise > 0 else 0
    unknown = 0
    for k in range(max(0, level - up), min(levels, level + up + 1)):
        for r in range(max(0, at - NEIGHBOURHOOD), min(height, at + NEIGHBOURHOOD + 1)):
            for c in range(max(0, col - NEIGHBOURHOOD), min(belief.shape[1], col + NEIGHBOURHOOD + 1)):
                unknown += belief[k * rise + r, c] == UNKNOWN
    others = (AROUND + 1) * (2 * up + 1) - 1
    return float(AROUND * (others + 1 - unknown)) / others


@kernel(entry=False)
def _weighted(
    belief: np.ndarray, cell: int, depths: np.ndarray, isolation: float, lidar: LidarModel, scan: Scan
) -> float:
    width, rise = belief.shape[1], rise_of(belief.shape[0], lidar.volume.levels)
    middle, levels = depths.shape[1] // 2, depths.shape[0] // 2
    row, col = divmod(cell, width)
    gain = 0.0
    for place in range(newly_visible_cells(belief, belief, row, col, lidar, scan)):
        r, c = divmod(scan.cells[place], width)
        if belief[r, c] == UNKNOWN:
            up, down, right = offset(row, col, r, c, rise)
            gain += depths[up + levels, down + middle, right + middle] * (
                1.0 + isolation * (known_around(belief, r, c, rise) / AROUND)
            )
    return gain


@kernel(entry=False)
def _bring_up_to_date(old: np.ndarray, new: np.ndarray) -> tuple[int, int, int, int]:
    """Copy ``new`` to ``old``; return the box around the changed cells as rows and columns, the ends excluded."""
    top, bottom, left, right = new.shape[0], 0, new.shape[1], 0
    for r in range(new.shape[0]):
        for c in range(new.shape[1]):
            if old[r, c] != new[r, c]:
                old[r, c] = new[r, c]
                top, bottom, left, right = min(top, r), r + 1, min(left, c), max(right, c + 1)
    return top, bottom, left, right


@kernel()
def _forget_changed(old: np.ndarray, new: np.ndarray, reach: int, gains: np.ndarray, levels: int, rise: int) -> None:
    """Copy ``new`` to ``old``, and mark the gains within ``reach`` of the box around each tile's changes as stale.

    ``levels`` is how many levels up and down these reach.
    """
    for row in range(0, new.shape[0], TILE):
        for col in range(0, new.shape[1], TILE):
            tile = slice(row, row + TILE), slice(col, col + TILE)
            top, bottom, left, right = _bring_up_to_date(old[tile], new[tile])
            if top < bottom:
                cols = max(0, col + left - reach), col + right + reach
                for level in range(-levels, levels + 1):
                    rows = row + top - reach + level * rise, row + bottom + reach + level * rise
                    gains[max(0, rows[0]) : max(0, rows[1]), cols[0] : cols[1]] = STALE


@kernel()
def _kept_gains(
    belief: np.ndarray, cells: np.ndarray, depths: np.ndarray, isolation: float, lidar: LidarModel, gains: np.ndarray
) -> np.ndarray:
    width = belief.shape[1]
    scan = new_scan(lidar)
    out = np.empty(cells.shape[0])
    for k in range(cells.shape[0]):
        row, col = divmod(cells[k], width)
        if gains[row, col] == STALE:
            gains[row, col] = _weighted(belief, cells[k], depths, isolation, lidar, scan)
        out[k] = gains[row, col]
    return out


@renamed(depth="decay_length")
class WeightedGains:
    """Weighted view gains, in which near and isolated cells have more weight; unchanged gains are cached.

    An unknown cell visible at distance r has the weight ``exp(-r / (decay_length R)) (1 + isolation k)``, R the lidar
    range and k the share of the 24 cells around it, or 124 over several levels, that are known or off the map: a far
    cell is more likely to be hidden behind a wall that is not known yet, and an isolated one would cost a detour later.

    Args:
        shape: (H, W) of the map.
        lidar_range: Lidar, or its range in cells.
        decay_length: Distance over which the weight falls to 1 / e, in lidar ranges; infinite for equal weights.
        isolation: Additional weight of a surrounded cell.

    """

    def __init__(
        self, shape: tuple[int, int], lidar_range: LidarModel | float, decay_length: float = inf, isolation: float = 0.0
    ) -> None:
        self._lens = lidar = model_of(lidar_range)
        reach = int(lidar.range + 1)
        away, self._levels = np.arange(-reach, reach + 1), min(reach, max(0, lidar.volume.levels - 1))
        levels = np.arange(-self._levels, self._levels + 1)[:, None, None]
        self._depths = np.exp(-np.hypot(np.hypot(away[:, None], away), levels) / (decay_length * lidar.range))
        self._isolation = float(isolation)
        self._reach = reach + NEIGHBOURHOOD
        self._rise = rise_of(shape[0], lidar.volume.levels)
        self._stale_levels = self._levels + NEIGHBOURHOOD if self._rise > 0 else 0
        self._belief = np.zeros(shape, np.uint8)
        self._gains = np.full(shape, STALE)

    def at(self, belief: Belief, cells: NDArray[np.int32]) -> NDArray[np.float64]:
        """Return the gains of (K,) flat cells, (K,)."""
        _forget_changed(self._belief, belief, self._reach, self._gains, self._stale_levels, self._rise)
        return np.asarray(_kept_gains(belief, cells, self._depths, self._isolation, self._lens, self._gains))
