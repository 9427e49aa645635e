"""Furniture for rooms: solid pieces along the walls and on the floor that never disconnect free cells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.grid.randomness import draw

#: Pieces tried for each wanted cell of furniture.
TRIES = 1.0
#: Of eight pieces, how many stand along a wall.
ALONG_WALL = 6
#: A piece is at most this long and this deep, in cells.
LONGEST, DEEPEST = 5, 2


@kernel()
def furnish(free: NDArray[np.bool_], rooms: NDArray[np.int64], share: float, key: np.uint64) -> None:
    """Put furniture on about a ``share`` of the floor of every room of ``free`` (H, W) bool, in place.

    ``rooms`` (n, 4) holds top, left, height and width; walls are all around. Connected cells stay connected.
    """
    counter = np.uint64(0)
    for n in range(rooms.shape[0]):
        top, left, tall, wide = rooms[n]
        wanted = int(share * tall * wide)
        for _ in range(int(TRIES * wanted)):
            if wanted <= 0 or tall < 3 or wide < 3:
                break
            bits = draw(key, counter)
            counter += np.uint64(1)
            deep = 1 + int(bits % np.uint64(DEEPEST))
            long = 2 + int((bits >> np.uint64(8)) % np.uint64(LONGEST - 1))
            side = int((bits >> np.uint64(16)) % np.uint64(4))
            h, w = (deep, long) if side < 2 else (long, deep)
            h, w = min(h, tall - 2), min(w, wide - 2)
            r = top + int((bits >> np.uint64(20)) % np.uint64(tall - h + 1))
            c = left + int((bits >> np.uint64(36)) % np.uint64(wide - w + 1))
            if (bits >> np.uint64(60)) % np.uint64(8) < ALONG_WALL:
                r = top if side == 0 else top + tall - h if side == 1 else r
                c = left if side == 2 else left + wide - w if side == 3 else c
            if free[r : r + h, c : c + w].all() and spares_the_way(free, r, c, h, w):
                free[r : r + h, c : c + w] = False
                wanted -= h * w


@kernel()
def spares_the_way(free: NDArray[np.bool_], top: int, left: int, tall: int, wide: int) -> bool:
    """Tell whether a rectangle of free cells (H, W) bool can become solid without disconnecting other free cells.

    It can if the free cells of the ring around it are one run: every path through the rectangle enters and leaves
    through the ring, and can follow the run instead. The ring must lie inside the map.
    """
    around = 2 * (tall + wide) + 4
    starts = frees = 0
    before = free[top, left - 1]  # the last cell of the ring
    for k in range(around):
        if k <= wide + 1:
            r, c = top - 1, left - 1 + k
        elif k <= wide + tall + 2:
            r, c = top + k - wide - 2, left + wide
        elif k <= 2 * wide + tall + 3:
            r, c = top + tall, left + wide - (k - wide - tall - 2)
        else:
            r, c = top + tall - (k - 2 * wide - tall - 3), left - 1
        frees += free[r, c]
        starts += free[r, c] and not before
        before = free[r, c]
    return frees == around or starts == 1
