from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env.grid.arrays import Mask

from .flights import maze, rooms


@pytest.fixture(params=["maze", "rooms", "noise", "open"])
def free(request: pytest.FixtureRequest) -> Mask:
    """Maps of different kinds."""
    kinds = {
        "maze": lambda: maze(5, 6, 1),
        "rooms": lambda: rooms(2, 4, 1),
        "noise": lambda: np.random.default_rng(1).random((14, 17)) > 0.35,
        "open": lambda: np.ones((9, 12), np.bool_),
    }
    return kinds[request.param]()
