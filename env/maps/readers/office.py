"""The bundled office floor, drawn for this project in ``office.txt`` beside this file.

Anyone may redraw it in a text editor: ``#`` wall, ``o`` furniture, ``.`` floor, one character a cell.
"""

from __future__ import annotations

from importlib import resources

import numpy as np

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.maps.floorplan import Floorplan

WALL, FURNITURE, FLOOR = "#", "o", "."
#: Metres a cell: the floor is 40 m by 24 m, its corridors 1.6 m and most of its doors 0.8 m wide.
RESOLUTION = 0.4


def office() -> Floorplan:
    """Return the office: 60 x 100 cells, a corridor loop around an open-plan area, rooms on both sides of it."""
    return drawn(resources.files(__package__).joinpath("office.txt").read_text(encoding="ascii"), "office", RESOLUTION)


def drawn(text: str, name: str, resolution: float | None = None) -> Floorplan:
    """Turn a drawing of equally long lines of ``#``, ``o`` and ``.`` into a floor plan; ``.`` alone is free.

    Raises :class:`InputError` for a line of another length or another character.
    """
    lines = text.split()
    for number, line in enumerate(lines, 1):
        if len(line) != len(lines[0]):
            raise InputError(
                f"{name}: expected {len(lines[0])} characters in line {number}, got {len(line)}; fix that line"
            )
        if unknown := set(line) - {WALL, FURNITURE, FLOOR}:
            raise InputError(
                f"{name}: expected only {WALL!r}, {FURNITURE!r} and {FLOOR!r} in line {number}, "
                f"got {min(unknown)!r}; replace it"
            )
    return Floorplan.from_free(np.array([list(line) for line in lines]) == FLOOR, name, resolution)
