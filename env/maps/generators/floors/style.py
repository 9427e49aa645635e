"""The style of a building: sizes of its corridors and rooms, and shares of the kinds of sections and details."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

#: Kinds of sections of a row of rooms, see :mod:`indoor_explorers.env.maps.generators.floors.sections`.
SECTIONS = ("rooms", "wide", "small", "services", "nested", "hall", "lobby", "gap", "stairs")
#: How often each use is drawn, and the mean shares of its sections.
USES = {
    "school": (0.5, (0.50, 0.18, 0.02, 0.05, 0.04, 0.10, 0.04, 0.04, 0.03)),
    "office": (0.25, (0.44, 0.24, 0.03, 0.04, 0.08, 0.08, 0.05, 0.02, 0.02)),
    "university": (0.25, (0.44, 0.22, 0.04, 0.05, 0.08, 0.08, 0.04, 0.03, 0.02)),
}
#: Metres: smallest and largest width of the usual room, its depth, and width of the main corridor.
SIZES = {
    "school": ((6.0, 12.0), (6.0, 12.0), (2.2, 5.0)),
    "office": ((3.0, 7.0), (3.6, 8.8), (1.6, 3.4)),
    "university": ((2.9, 7.0), (3.7, 8.2), (1.7, 3.8)),
}
#: Share of plans with an axis of symmetry.
SYMMETRIC = 0.15
#: Share of buildings with furniture.
FURNISHED = 0.2
#: How much the shares of sections differ between buildings: the concentration of a Dirichlet distribution.
CONCENTRATION = 12.0


class Style(NamedTuple):
    """Common properties of the rooms and corridors of one building; lengths in cells."""

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
    niches: float
    """Share of rooms with a niche or a half wall."""
    fire_doors: float
    """Fire doors for each usual length of corridor."""
    symmetric: bool
    """Whether the plan has an axis of symmetry."""
    metre: float
    """Cells a metre."""

    def cells(self, metres: float, least: int = 1) -> int:
        """Return a length in cells."""
        return max(least, round(metres * self.metre))


def draw_style(rng: np.random.Generator, resolution: float, loops: float, furniture: float) -> Style:
    """Return a random style for cells of ``resolution`` metres."""
    uses = list(USES)
    use = uses[int(rng.choice(len(uses), p=[share for share, _ in USES.values()]))]
    module, depth, corridor = (rng.uniform(*bounds) / resolution for bounds in SIZES[use])
    return Style(
        module=max(2, round(module)),
        depth=max(2, round(depth)),
        corridor=max(1, round(corridor)),
        aisle=max(1, round(corridor * rng.uniform(0.6, 1.0))),
        sections=tuple(rng.dirichlet(np.array(USES[use][1]) * CONCENTRATION).tolist()),
        thick=float(rng.beta(1.2, 2.0)),
        loaded=float(rng.choice([1.0, 0.9, 0.75, 0.55], p=[0.4, 0.3, 0.2, 0.1])),
        ragged_row=float(rng.uniform(0.0, 0.6)),
        loops=min(1.0, loops * float(rng.gamma(0.8, 1.25))),
        wide_doors=float(rng.beta(1.5, 3.0)),
        furnished=furniture * float(rng.uniform(0.3, 1.7)) if rng.random() < FURNISHED else 0.0,
        niches=float(rng.beta(1.2, 2.5)),
        fire_doors=float(rng.uniform(0.3, 1.5)) if rng.random() < 0.35 else 0.0,
        symmetric=bool(rng.random() < SYMMETRIC),
        metre=1.0 / resolution,
    )
