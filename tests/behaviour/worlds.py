"""The maps, teams, radios, and lidars that policies are flown with."""

from __future__ import annotations

from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np

from indoor_explorers.env.grid.arrays import Mask
from tests.behaviour.covering import pairwise
from tests.planners.flights import maze, rooms

Settings = dict[str, Any]
#: Presets, or map files that :func:`write_maps` makes, and settings, by name.
WORLDS: dict[str, tuple[str, Settings]] = {
    "room": ("thesis-obstacles", {}),
    "pockets": ("thesis-obstacles", {"map.obstacles": 40, "map.obstacle_size": [1, 3]}),
    "rooms": ("rooms", {"map.height": 32, "map.width": 32, "lidar.range": 5}),
    "offices": ("offices", {"map.height": 40, "map.width": 40, "lidar.range": 6}),
    "cave": ("cave", {"map.height": 32, "map.width": 32, "lidar.range": 5}),
    "maze": ("maze", {"map.height": 33, "map.width": 33, "lidar.range": 5}),
    "corridors": ("maze", {"map.height": 21, "map.width": 21, "map.corridor": 1, "map.braid": 0, "lidar.range": 3}),
    "comb": ("comb.npy", {"lidar.range": 2}),
    "plus": ("plus.npy", {"lidar.range": 2}),
    "open": ("open.npy", {"lidar.range": 3}),
    "noise": ("noise.npy", {"lidar.range": 3}),
    "small-rooms": ("small-rooms.npy", {"lidar.range": 3}),
    "small-maze": ("small-maze.npy", {"lidar.range": 3}),
}
#: Those that make soak flies with every lidar.
SMALL = ("open", "noise", "small-rooms", "small-maze")
#: Worlds of one kind take turns in the rows of the covering array.
KINDS = {
    "open": ("open", "room"),
    "cluttered": ("cave", "noise", "pockets"),
    "rooms": ("small-rooms", "rooms"),
    "corridors": ("corridors", "small-maze", "comb"),
}
#: Radio settings by name; with ``each``, every UAV has to see everything itself.
RADIOS: dict[str, Settings] = {
    "none": {"radio.model": "none"},
    "square": {"radio.model": "square", "radio.range": 3},
    "disc": {"radio.model": "disc", "radio.range": 6},
    "unlimited": {"radio.model": "unlimited"},
    "loss": {"radio.model": "unlimited", "radio.loss": 0.3},
    "sight": {"radio.model": "line-of-sight", "radio.range": 12},
    "each": {"radio.model": "none", "goal_of": "agent"},
}
#: What every two of are flown together.
FACTORS = {
    "kind": tuple(KINDS),
    "team": (1, 4, 16),
    "radio": ("none", "disc", "unlimited"),
    "lidar": (1.0, 3.0, 5.5),
}
#: Steps of an episode, far more than any of them needs.
BUDGET = 4000


def covering_array() -> list[dict[str, Any]]:
    """Return rows of kind, team, radio, lidar, and the world of this kind whose turn it is."""
    turns = {kind: cycle(worlds) for kind, worlds in KINDS.items()}
    return [{**row, "world": next(turns[row["kind"]])} for row in pairwise(FACTORS)]


def small_maps() -> dict[str, Mask]:
    """Return the free cells of a few small maps; comb is a row of dead ends and plus a crossing, one cell wide."""
    comb = np.zeros((13, 25), np.bool_)
    comb[6, 1:-1] = comb[1:6, 1:-1:2] = comb[7:-1, 2:-1:3] = True
    plus = np.zeros((31, 31), np.bool_)
    plus[15, 1:-1] = plus[1:-1, 15] = True
    plus[13:18, 13:18] = True
    return {
        "comb": comb,
        "plus": plus,
        "open": np.ones((9, 12), np.bool_),
        "noise": np.random.default_rng(1).random((14, 17)) > 0.35,
        "small-rooms": rooms(2, 4, 1),
        "small-maze": maze(5, 6, 1),
    }


def write_maps(folder: Path) -> None:
    """Write the small maps as files NAME.npy."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, free in small_maps().items():
        np.save(folder / f"{name}.npy", (~free).astype(np.uint8))
