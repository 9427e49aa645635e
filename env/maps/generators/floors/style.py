"""The style of a building: how wide its corridors are, how large its rooms, and what its rows of rooms hold."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

#: Kinds of sections of a row of rooms, see :mod:`indoor_explorers.env.maps.generators.floors.sections`.
SECTIONS = ("rooms", "wide", "small", "services", "nested", "hall", "lobby", "gap", "stairs")
#: Their mean shares in schools, offices and university buildings.
USES = {
    "school": (0.46, 0.15, 0.03, 0.08, 0.07, 0.05, 0.05, 0.06, 0.05),
    "office": (0.44, 0.14, 0.05, 0.06, 0.13, 0.04, 0.07, 0.03, 0.04),
    "university": (0.44, 0.15, 0.06, 0.07, 0.11, 0.04, 0.05, 0.04, 0.04),
}
#: Metres: smallest and largest width of the usual room, its depth, and width of the main corridor.
SIZES = {
    "school": ((5.5, 9.5), (5.5, 9.5), (1.8, 4.2)),
    "office": ((2.6, 5.0), (3.2, 7.0), (1.3, 2.6)),
    "university": ((2.6, 6.0), (3.5, 7.0), (1.5, 3.2)),
}
#: How much the shares of sections differ between buildings: the concentration of a Dirichlet distribution.
CONCENTRATION = 12.0


class Style(NamedTuple):
    """What the rooms and corridors of one building have in common; lengths in cells."""

    module: int
    """Width of the usual room."""
    depth: int
    """Depth of the usual row of rooms."""
    corridor: int
    """Width of main corridors."""
    aisle: int
    """Width of lesser corridors."""
    sections: tuple[float, ...]
    """Shares of the sections of :data:`SECTIONS`."""
    thick: float
    """Share of walls that are two cells thick."""
    loaded: float
    """Share of sides of corridors with rooms."""
    ragged_row: float
    """Share of sections whose depth differs from that of their row."""
    loops: float
    """Share of walls between neighbouring spaces that have a door though there is another way."""
    wide_doors: float
    """Share of doors that are wider than one door leaf."""
    furnished: float
    """Share of the floor of furnished rooms under furniture; 0 in bare buildings."""
    metre: float
    """Cells a metre."""

    def cells(self, metres: float, least: int = 1) -> int:
        """Return a length in cells."""
        return max(least, round(metres * self.metre))


def draw_style(rng: np.random.Generator, resolution: float, loops: float, furniture: float) -> Style:
    """Return a random style for cells of ``resolution`` metres."""
    use = ("school", "office", "university")[int(rng.integers(3))]
    module, depth, corridor = (rng.uniform(*bounds) / resolution for bounds in SIZES[use])
    return Style(
        module=max(2, round(module)),
        depth=max(2, round(depth)),
        corridor=max(1, round(corridor)),
        aisle=max(1, round(corridor * rng.uniform(0.5, 1.0))),
        sections=tuple(rng.dirichlet(np.array(USES[use]) * CONCENTRATION).tolist()),
        thick=float(rng.beta(1.2, 2.0)),
        loaded=float(rng.choice([1.0, 0.9, 0.75, 0.55], p=[0.4, 0.3, 0.2, 0.1])),
        ragged_row=float(rng.uniform(0.0, 0.6)),
        loops=min(1.0, loops * float(rng.gamma(2.0, 0.5))),
        wide_doors=float(rng.beta(2.0, 2.5)),
        furnished=furniture * float(rng.uniform(0.3, 1.7)) if rng.random() < 0.5 else 0.0,
        metre=1.0 / resolution,
    )
