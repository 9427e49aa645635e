"""Assignment of UAVs to places with the least total cost."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment


def matched(costs: NDArray[np.float64], extra: float) -> NDArray[np.int64]:
    """Return the place of each of N UAVs among K places, (N,), with the least total of (N, K) ``costs``.

    With fewer places than UAVs, up to ceil(N / K) UAVs share a place; all but the first have an ``extra`` cost
    (H. W. Kuhn, "The Hungarian method for the assignment problem", 1955, doi:10.1002/nav.3800020109).
    """
    uavs, places = costs.shape
    copies = -(-uavs // places)
    repeated = np.concatenate([costs + (extra if copy else 0.0) for copy in range(copies)], axis=1)
    return np.asarray(linear_sum_assignment(repeated)[1] % places, np.int64)
