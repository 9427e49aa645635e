"""Plug-ins of a scenario for tests."""

import numpy as np
from pydantic import Field

from indoor_explorers.env import GeneratedMaps
from indoor_explorers.env.grid.cells import UNKNOWN
from indoor_explorers.env.sensing.lidar import scan


class Pillars(GeneratedMaps):
    """An empty hall with pillars."""

    every: int = Field(6, ge=3)
    """Cells between two pillars."""

    def draw(self, rng: np.random.Generator) -> np.ndarray:
        free = np.zeros((self.height, self.width), np.bool_)
        free[1:-1, 1:-1] = True
        row, col = rng.integers(1, self.every, 2)
        free[row :: self.every, col :: self.every] = False
        return free


def exact(truth, cell, lidar_range):
    """The exact lidar."""
    return scan(truth, cell, lidar_range) != UNKNOWN


def square_view(truth, cell, lidar_range):
    """A square, through all walls."""
    seen = np.zeros(truth.shape, np.bool_)
    reach = int(lidar_range)
    seen[max(0, cell[0] - reach) : cell[0] + reach + 1, max(0, cell[1] - reach) : cell[1] + reach + 1] = True
    return seen


def disc(truth, cells, radio):
    """The disc radio."""
    return ((cells[:, None] - cells[None]) ** 2).sum(axis=2) <= radio.range**2


def one_way(truth, cells, radio):
    return np.triu(np.ones((len(cells),) * 2))


def flat(truth, cell, lidar_range):
    return np.ones(truth.size)


def broken(truth, cells, radio):
    raise ZeroDivisionError("no antenna")


NUMBER = 3
