"""Doors between the spaces of a floor: a random tree that reaches them all, and some more for loops."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.maps.generators.floors.site import OPEN, Spaces
from indoor_explorers.env.maps.generators.floors.style import Style
from indoor_explorers.env.search.connected_parts import spanning_tree

#: The thickest wall that a door goes through, in cells.
THICKEST = 3
#: Share of rooms at a corridor that are entered from it, if there is another way in.
FROM_CORRIDOR = 0.94


class Walls(NamedTuple):
    """Straight pieces of wall with one space along each side, (n,) arrays; lengths in cells."""

    one: NDArray[np.int64]
    other: NDArray[np.int64]
    standing: NDArray[np.int64]
    """1 for a wall between a space and the one to its right, 0 for one between a space and the one below."""
    thick: NDArray[np.int64]
    row: NDArray[np.int64]
    """Of the first cell of the wall, like ``col``."""
    col: NDArray[np.int64]
    long: NDArray[np.int64]


class Door(NamedTuple):
    """A rectangle of cells that is opened, and the axis along which it is passed: 0 rows, 1 columns."""

    row: int
    col: int
    tall: int
    wide: int
    axis: int


def walls_between(spaces: Spaces) -> Walls:
    """Return all straight pieces of wall, up to :data:`THICKEST` cells thick, between two spaces."""
    found = [_cells(spaces, thick, standing) for thick in range(1, THICKEST + 1) for standing in (0, 1)]
    one, other, standing, thick, line, place = np.concatenate(found, axis=1)
    order = np.lexsort((place, line, thick, standing, other, one))
    columns = np.stack([one, other, standing, thick, line, place])[:, order]
    new = np.ones(columns.shape[1], np.bool_)
    new[1:] = (np.diff(columns[:5], axis=1) != 0).any(axis=0) | (np.diff(columns[5]) != 1)
    first = np.flatnonzero(new)
    long = np.diff(np.append(first, columns.shape[1]))
    one, other, standing, thick, line, place = columns[:, first]
    row, col = np.where(standing == 1, place, line), np.where(standing == 1, line, place)
    return Walls(one, other, standing, thick, row, col, long)


def _cells(spaces: Spaces, thick: int, standing: int) -> NDArray[np.int64]:
    """Return (6, n): the two spaces, orientation, thickness, line and place along it of each cell of wall."""
    grid = spaces.T if standing else spaces
    near, far = grid[: -thick - 1], grid[thick + 1 :]
    wall = (near > 0) & (far > 0) & (near != far)
    for depth in range(1, thick + 1):
        wall &= grid[depth : depth + len(near)] == 0
    line, place = np.nonzero(wall)
    one, other = near[line, place], far[line, place]
    low, high = np.minimum(one, other), np.maximum(one, other)
    same = np.ones_like(line)
    return np.stack([low, high, same * standing, same * thick, line + 1, place]).astype(np.int64)


def doors(rng: np.random.Generator, spaces: Spaces, style: Style) -> list[Door]:
    """Return doors that join all spaces that can be joined, and about the style's share of further ones."""
    walls = walls_between(spaces)
    if not len(walls.one):
        return []
    chosen = np.zeros(len(walls.one), np.bool_)
    chosen[_tree(rng, walls, int(spaces.max()))] = True
    spare = ~chosen & (walls.long >= style.cells(1.5, 2))
    corridor = walls.one == OPEN
    likely = np.where(corridor, 2.0 * style.loops, style.loops)
    chosen |= spare & (rng.random(len(chosen)) < likely)
    made = [_door(rng, walls, int(number), style) for number in np.flatnonzero(chosen)]
    second = chosen & corridor & (walls.long >= style.cells(5.0)) & (rng.random(len(chosen)) < 3.0 * style.loops)
    return made + [_door(rng, walls, int(number), style) for number in np.flatnonzero(second)]


def _tree(rng: np.random.Generator, walls: Walls, last: int) -> NDArray[np.int64]:
    """Return the numbers of the walls whose doors make a tree of all spaces, most of them to corridors."""
    weights = 2.0 + rng.random(len(walls.one)) - 0.5 * (walls.long > 4)
    direct = (walls.one == OPEN) & (rng.random(len(walls.one)) < FROM_CORRIDOR)
    weights[direct] = 0.5 + 0.4 * rng.random(int(direct.sum())) - 0.3 * (walls.long[direct] > 4)
    order = np.argsort(weights, kind="stable")
    pairs = walls.one * (last + 1) + walls.other
    _, first = np.unique(pairs[order], return_index=True)
    best = order[first]
    return best[spanning_tree(np.stack([walls.one, walls.other], axis=1)[best], weights[best], last + 1)]


def _door(rng: np.random.Generator, walls: Walls, number: int, style: Style) -> Door:
    """Return a door in a wall, more often near one of its ends than in the middle."""
    long, thick = int(walls.long[number]), int(walls.thick[number])
    width = style.cells(rng.uniform(0.3, 0.9))
    if rng.random() < style.wide_doors:
        width = style.cells(rng.uniform(1.0, 2.2))
    width = min(width, long)
    spare = long - width
    place = int(rng.integers(spare + 1))
    if rng.random() < 0.6:
        place = min(int(rng.integers(3)), spare)
        place = spare - place if rng.random() < 0.5 else place
    row, col = int(walls.row[number]), int(walls.col[number])
    if walls.standing[number]:
        return Door(row + place, col, width, thick, 1)
    return Door(row, col + place, thick, width, 0)


def open_doors(free: Mask, made: list[Door]) -> None:
    """Make the cells of doors free, in place."""
    for door in made:
        free[door.row : door.row + door.tall, door.col : door.col + door.wide] = True
