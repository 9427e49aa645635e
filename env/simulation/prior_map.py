"""The prior map of an episode: the true map, or an outdated one with changed doors, walls and furniture.

It depends on the true map, the scenario's settings and the episode's seed alone. Each kind of change has its own random
generator, so that one setting never affects the other changes.
"""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING

import numpy as np

from indoor_explorers.env.grid.arrays import Belief, Mask
from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.grid.randomness import Stream, generator
from indoor_explorers.env.maps.walls import Block, doorways, standing_obstacles, straight_walls

if TYPE_CHECKING:
    from indoor_explorers.env.scenarios.parts import Prior


class PriorChange(IntEnum):
    """A kind of change; the value is part of a generator's seed and never changes."""

    DOORS = 0
    OPENINGS = 1
    SHIFT = 2
    FURNITURE = 3


def prior_map(truth: Belief, settings: Prior, seed: int) -> Belief:
    """Return the prior map of a true map, both (H, W) uint8, as a new array.

    Furniture is removed first, then walls are moved and opened, then doorways are shut.
    """
    prior = truth.copy()
    if settings.kind != "outdated":
        return prior
    pieces, walls, doors = standing_obstacles(truth), straight_walls(truth), doorways(truth)
    gone, _ = _drawn(seed, PriorChange.FURNITURE, len(pieces), settings.furniture)
    for k in np.flatnonzero(gone):
        mask, box = pieces[k]
        prior[box][mask] = FREE
    moved, sides = _drawn(seed, PriorChange.SHIFT, len(walls), settings.shift)
    opened, places = _drawn(seed, PriorChange.OPENINGS, len(walls), settings.openings)
    width = _usual_width(doors)
    for k in np.flatnonzero(moved | opened):
        wall = walls[k]
        if moved[k]:
            prior[wall.cells] = FREE
            wall = _shifted(wall, 1 if sides[k] < 0.5 else -1)
            prior[wall.cells] = OCCUPIED
        if opened[k]:
            prior[_hole(wall, width, places[k]).cells] = FREE
    shut, _ = _drawn(seed, PriorChange.DOORS, len(doors), settings.doors)
    for k in np.flatnonzero(shut):
        prior[doors[k].cells] = OCCUPIED
    return prior


def _drawn(seed: int, change: PriorChange, places: int, probability: float) -> tuple[Mask, np.ndarray]:
    """Draw which places change, (K,) bool, and another number from 0 to 1 for each, (K,)."""
    numbers = generator(seed, Stream.PRIOR, change).random((places, 2))
    return numbers[:, 0] < probability, numbers[:, 1]


def _usual_width(doors: list[Block]) -> int:
    """Return the median width of doorways in cells, 1 where there are none."""
    widths = [door.height if door.upright else door.width for door in doors]
    return int(np.median(widths)) if widths else 1


def _shifted(wall: Block, by: int) -> Block:
    """Return a wall moved sideways; it has free cells on both sides, so it stays on the map."""
    return wall._replace(left=wall.left + by) if wall.upright else wall._replace(top=wall.top + by)


def _hole(wall: Block, width: int, place: float) -> Block:
    """Return the doorway of a width at a place, 0 to 1, along a wall; the wall's ends stay."""
    length = wall.height if wall.upright else wall.width
    first = 1 + int(place * (length - 1 - width))
    if wall.upright:
        return wall._replace(top=wall.top + first, height=width)
    return wall._replace(left=wall.left + first, width=width)
