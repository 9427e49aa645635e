"""Slow lidars, independent of the compiled ones: line of sight in rational arithmetic, and the ancestor's rays."""

from fractions import Fraction

import numpy as np

from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN

DIAGONALS = [
    ((0, 0), (1, 1), (0, 1), (1, 0)),
    ((0, 1), (1, 0), (0, 0), (1, 1)),
]


def overlap(low, high, start, change):
    """Times at which a moving coordinate is strictly between low and high."""
    if change == 0:
        return (Fraction(-1), Fraction(2)) if low < start < high else None
    ends = Fraction(low - start, change), Fraction(high - start, change)
    return min(ends), max(ends)


def crosses(truth, start, end):
    """Whether a segment between two points in half cells runs through an obstacle, or between two at a corner."""
    (y0, x0), (y1, x1) = start, end
    dy, dx = y1 - y0, x1 - x0
    for r, c in np.argwhere(truth == OCCUPIED).tolist():
        rows, cols = overlap(2 * r - 1, 2 * r + 1, y0, dy), overlap(2 * c - 1, 2 * c + 1, x0, dx)
        if rows and cols and max(rows[0], cols[0], 0) < min(rows[1], cols[1], 1):
            return True
    for r, c in np.ndindex(truth.shape[0] - 1, truth.shape[1] - 1):
        y, x = 2 * r + 1, 2 * c + 1
        if (y - y0) * dx != (x - x0) * dy or not min(y0, y1) <= y <= max(y0, y1):
            continue
        if not min(x0, x1) <= x <= max(x0, x1):
            continue
        solid = truth[r : r + 2, c : c + 2] == OCCUPIED
        if any(solid[a] and solid[b] and not solid[p] and not solid[q] for a, b, p, q in DIAGONALS):
            return True
    return False


def reference_scan(truth, cell, lidar_range):
    """The rules of the docstring, one cell at a time."""
    belief = np.full(truth.shape, UNKNOWN)
    row, col = cell
    for r, c in np.ndindex(truth.shape):
        if (r - row) ** 2 + (c - col) ** 2 > Fraction(lidar_range) ** 2:
            continue
        if truth[r, c] == FREE:
            if not crosses(truth, (2 * row, 2 * col), (2 * r, 2 * c)):
                belief[r, c] = FREE
            continue
        for dr, dc in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            inside = 0 <= r + dr < truth.shape[0] and 0 <= c + dc < truth.shape[1]
            if (
                inside
                and truth[r + dr, c + dc] == FREE
                and not crosses(truth, (2 * row, 2 * col), (2 * r + dr, 2 * c + dc))
            ):
                belief[r, c] = OCCUPIED
    return belief


def ancestor_scan(truth, cell, lidar_range):
    """MarsExplorer's Lidar.update, step by step in numpy: 32 rays of 200 samples, cut half a cell behind a hit."""
    position, angles = np.array(cell), np.linspace(0, 2 * np.pi, 32, endpoint=False)
    heading = np.stack((np.cos(angles), np.sin(angles)), axis=1)

    def cells_along(lengths):
        samples = np.linspace(position, position + np.asarray(lengths).reshape(-1, 1) * heading, 200)
        return np.clip(np.round(samples).astype(int), 0, np.array(truth.shape) - 1)

    lengths = np.full(32, lidar_range)
    for ray, way in enumerate(cells_along(lengths).transpose(1, 0, 2)):
        hits = way[truth[way[:, 0], way[:, 1]] == OCCUPIED]
        if len(hits):
            lengths[ray] = np.linalg.norm(hits - position, axis=1).min()
    seen = cells_along(np.clip(lengths + 0.5, 0, lidar_range)).reshape(-1, 2)
    belief = np.full(truth.shape, UNKNOWN)
    belief[seen[:, 0], seen[:, 1]] = truth[seen[:, 0], seen[:, 1]]
    return belief
