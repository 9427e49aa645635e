from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env.grid.arrays import Belief, Cell, Mask
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN

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


@pytest.fixture(params=range(6))
def belief(request: pytest.FixtureRequest) -> Belief:
    """A random half-known map."""
    rng = np.random.default_rng(request.param)
    shape = (int(rng.integers(1, 25)), int(rng.integers(2, 25)))
    blocks = rng.random((-(-shape[0] // 3), -(-shape[1] // 3))) < 0.3
    unknown = np.kron(blocks, np.ones((3, 3), np.bool_))[: shape[0], : shape[1]].astype(np.bool_)
    cells = np.where(rng.random(shape) < 0.25, OCCUPIED, FREE)
    return np.where(unknown, UNKNOWN, cells).astype(np.uint8)


@pytest.fixture
def start(belief: Belief) -> Cell:
    """A free cell of that map."""
    row, col = np.argwhere(belief == FREE)[0].tolist()
    return row, col
