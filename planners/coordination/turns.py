"""Taking turns: whoever has the best cluster takes it first, and the next ones keep away from it.

Sequential greedy assignment as in W. Burgard, M. Moors, C. Stachniss, F. Schneider, "Coordinated multi-robot
exploration", IEEE T-RO 2005, doi:10.1109/TRO.2004.839232; there the target loses utility for those that follow, here
also the clusters near it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def left_over(
    worth: NDArray[np.float64], points: NDArray[np.float64], me: int, radius: float, taken: float
) -> NDArray[np.float64]:
    """Return the share of each of K clusters that those who choose before UAV ``me`` leave to it, (K,) in [taken, 1].

    ``worth`` is (N, K), what each cluster is worth to each UAV, 0 where it cannot go; ``points`` (K, 2) are the
    clusters' rows and columns. The highest worth of all chooses first. A cluster that is chosen keeps the share
    ``taken``, one ``radius`` cells away all of itself, and those between in proportion.
    """
    share = np.ones(worth.shape[1])
    waiting = list(range(len(worth)))
    while True:
        worths = worth[waiting] * share
        turn, cluster = divmod(int(worths.argmax()), worth.shape[1])
        if waiting[turn] == me or worths[turn, cluster] <= 0.0:
            return share
        waiting.pop(turn)
        away = np.hypot(*(points - points[cluster]).T)
        share = np.maximum(taken, share * np.minimum(1.0, away / radius))
