"""Steps between poses, cells with a heading, where a UAV faces the direction of its last move or turns clockwise.

A move takes one step whatever the heading before, and a turn by 90 degrees takes one. So a shortest way to a pose is a
shortest path to one of the four cells around it, one more move, and the turns that are left.
"""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.cells import FREE, MOVES, UNREACHABLE
from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.search.bfs import flood, flood_nearby

#: Heading of a UAV whose heading is not known: any.
ANY = -1


@leaf(entry=False)
def _steps_to(steps: np.ndarray, shape: tuple[int, int], start: int, facing: int, cell: int, heading: int) -> int:
    """Return the steps from the pose (``start``, ``facing``) to another; ``steps`` (H*W,) are those from ``start``."""
    best = UNREACHABLE
    if cell == start:
        best = np.int32(0 if ANY in (facing, heading) else (heading - facing) % 4)
    row, col = divmod(cell, shape[1])
    for last in range(4):
        r, c = row - MOVES[last, 0], col - MOVES[last, 1]
        if 0 <= r < shape[0] and 0 <= c < shape[1] and steps[r * shape[1] + c] < UNREACHABLE:
            turns = 0 if heading == ANY else (heading - last) % 4
            best = min(best, np.int32(steps[r * shape[1] + c] + 1 + turns))
    return int(best)


@kernel()
def pose_steps(
    fields: np.ndarray, starts: np.ndarray, facing: np.ndarray, cells: np.ndarray, headings: np.ndarray
) -> np.ndarray:
    """Return the steps from N poses to K others, (N, K); ``UNREACHABLE`` without a known path.

    ``fields`` (N, H, W) are the steps from the flat cells ``starts``; ``facing`` (N,) and ``headings`` (K,) may be
    ``ANY``.
    """
    count, shape = fields.shape[0], (fields.shape[1], fields.shape[2])
    out = np.empty((count, cells.shape[0]), np.int64)
    for n in range(count):
        steps = fields[n].reshape(shape[0] * shape[1])
        for k in range(cells.shape[0]):
            out[n, k] = _steps_to(steps, shape, starts[n], facing[n], cells[k], headings[k])
    return out


@kernel()
def steps_between(
    belief: np.ndarray, cells: np.ndarray, headings: np.ndarray, away: np.ndarray, limit: int
) -> np.ndarray:
    """Return the steps from each of K poses to each other one, (K, K), row by row.

    Where the path is longer than ``limit``, an upper bound is returned: the path through a UAV's cell, from the (N, K)
    steps ``away``.
    """
    count, shape = cells.shape[0], belief.shape
    queue, out = np.empty(belief.size, np.int32), np.full(belief.size, UNREACHABLE, np.int32)
    between, reached = np.empty((count, count)), 0
    for k in range(count):
        if k == 0 or cells[k] != cells[k - 1]:
            for place in range(reached):
                out[queue[place]] = UNREACHABLE
            reached = flood_nearby(belief, cells[k], -1, limit, queue, out)
        for j in range(count):
            between[k, j] = _steps_to(out, shape, cells[k], headings[k], cells[j], headings[j])
            if between[k, j] >= UNREACHABLE:
                for i in range(away.shape[0]):
                    between[k, j] = min(between[k, j], away[i, k] + away[i, j])
    return between


@kernel()
def steps_left(belief: np.ndarray, goal: int, heading: int) -> np.ndarray:
    """Return the steps to a pose from each cell of a (H, W) belief for a UAV that moves first, (H, W).

    ``UNREACHABLE`` without a known path. A UAV in the goal's own cell may also turn.
    """
    height, width = belief.shape
    out, count = np.full(belief.shape, UNREACHABLE, np.int32), 0
    queue = np.empty(4 * belief.size, np.int32)  # the sources differ by three steps, so a cell may be reached again
    for turns in range(4):
        last = turns if heading == ANY else (heading - turns) % 4
        r, c = goal // width - MOVES[last, 0], goal % width - MOVES[last, 1]
        if 0 <= r < height and 0 <= c < width and belief[r, c] == FREE:
            out[r, c], queue[count] = 1 if heading == ANY else 1 + turns, r * width + c
            count += 1
    flood(belief, FREE, count, queue, out)
    return out
