"""Caves: noise smoothed by a cellular automaton, its parts joined by tunnels.

The automaton is that of Johnson, Yannakakis and Togelius, Cellular automata for real-time generation of infinite
cave levels (2010), doi 10.1145/1814256.1814266: a cell is solid when at least five of the 3 x 3 cells around it are.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.maps.base import GeneratedMaps
from indoor_explorers.env.maps.generators.joining import joined

#: A cave with a smaller free share than this is drawn again with less rock.
ENOUGH = 0.15
#: How much less rock each further try starts from; without any it is one open chamber.
EASING = 0.05


class CaveMaps(GeneratedMaps):
    """Random caves."""

    source: Literal["cave"] = "cave"
    rock: float = Field(0.45, ge=0.0, le=0.6)
    """Share of cells that are solid before smoothing; from about 0.5 on chambers come apart and tunnels join them."""
    smoothing: int = Field(5, ge=0, le=50)
    """Rounds of the automaton; each makes the walls rounder."""
    chamber: int = Field(20, ge=1)
    """Cells of the smallest chamber; smaller pockets become solid."""

    def draw(self, rng: np.random.Generator) -> Mask:
        """Return the (height, width) mask of the cave."""
        noise = rng.random((self.height, self.width))
        for rock in np.arange(self.rock, 0.0, -EASING).tolist():
            free = joined(self._smoothed(noise < rock), self.chamber)
            if free.mean() >= ENOUGH:
                return free
        return ~_closed(np.zeros_like(noise, np.bool_))

    def _smoothed(self, solid: Mask) -> Mask:
        """Run the automaton on a mask of solid cells, with solid rock around it; return the free cells."""
        solid = _closed(solid)
        for _ in range(self.smoothing):
            padded = np.pad(solid, 1, constant_values=True).astype(np.uint8)
            rows = padded[:-2] + padded[1:-1] + padded[2:]
            solid = _closed(rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:] >= 5)
        return ~solid


def _closed(solid: Mask) -> Mask:
    """Return a mask of solid cells with the border solid."""
    return np.pad(solid[1:-1, 1:-1], 1, constant_values=True)
