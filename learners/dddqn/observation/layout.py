"""Where everything is in an observation, and how it turns with the world.

An observation has two parts. ``scene`` (S,) uint8, 255 standing for 1: the layers of the fine map, the coarse map's
unknown and known free cells (and mates, where the fine map shows them), the four sides, identity, progress. ``moves``
(4, F) float32: for each move, whether it is blocked and the features that are switched on.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import MOVES
from indoor_explorers.learners.dddqn.observation.config import LAYERS, ObservationConfig

#: How many flips and quarter turns there are; number 0 leaves everything as it is.
SYMMETRIES = 8
#: UAVs that identity tells apart; more of them share.
IDENTITIES = 8
#: Numbers of progress.
PROGRESS = 3
#: Features of each move, by the switch that turns them on; the first is always there.
BLOCKED = ("blocked",)
BLOCKED_AT = 0
GAINS = (
    "gain there",
    "distance to the nearest gain",
    "best gain ahead, discount .7",
    "best gain ahead, discount .85",
    "best gain ahead, discount .95",
    "sum of the gain ahead, discount .7",
)
VISITS = ("visits since the last gain",)
TOURS = (
    "a tour to the goal was found",
    "its steps beyond the shortest",
    "it is the shortest",
    "its steps",
    "its delay beyond the least",
    "its delay",
    "unknown share",
    "a tour to 90 % was found",
    "its steps beyond the shortest to 90 %",
    "it is the shortest to 90 %",
    "its steps to 90 %",
    "steps of the tour to the goal until 90 %",
)
PROSPECTS = ("by all that is in view", "with isolated cells counting more")
PROSPECT = ("there is one", "steps behind the best", "it is the best", "distance", "what is in view there")

#: Steps beyond the shortest tour, or behind the best prospect, at which that feature is 1.
BEYOND = 8.0


class ObservationLayout(NamedTuple):
    """Offsets and sizes as plain numbers for compiled code; an offset of -1 means left out."""

    crop: int
    coarse: int
    layers: NDArray[np.int64]
    """(8,) where each of :data:`indoor_explorers.learners.dddqn.observation.config.LAYERS` begins in the scene."""
    coarse_at: int
    coarse_mates: bool
    sides_at: int
    identity_at: int
    progress_at: int
    scene: int
    """Numbers of one scene, S."""
    gains_at: int
    """Where the gains begin among the features of a move."""
    visits_at: int
    tours_at: int
    prospects_at: int
    features: int
    """Features of a move, F."""
    frames: int
    """Scenes shown together."""

    @property
    def inputs(self) -> int:
        """Numbers of all scenes shown together."""
        return self.scene * self.frames


@lru_cache(maxsize=64)
def observation_layout(config: ObservationConfig) -> ObservationLayout:
    """Work out the layout of an observation."""
    at, layers = 0, np.full(len(LAYERS), -1)
    for layer in config.layers:
        layers[LAYERS.index(layer)], at = at, at + config.crop**2
    mates = "mates" in config.layers or "mates_past" in config.layers
    coarse_at, sides_at, identity_at, progress_at, scene = _places(
        at,
        (2 + mates) * config.coarse**2,
        4 * config.sides,
        IDENTITIES * config.identity,
        PROGRESS * config.progress,
    )
    gains_at, visits_at, tours_at, prospects_at, features = _places(
        len(BLOCKED),
        len(GAINS) * config.gains,
        len(VISITS) * config.visits,
        len(TOURS) * config.tours,
        len(PROSPECTS) * len(PROSPECT) * config.prospects,
    )
    layers.setflags(write=False)
    return ObservationLayout(
        crop=config.crop,
        coarse=config.coarse,
        layers=layers,
        coarse_at=coarse_at,
        coarse_mates=mates,
        sides_at=sides_at,
        identity_at=identity_at,
        progress_at=progress_at,
        scene=scene,
        gains_at=gains_at,
        visits_at=visits_at,
        tours_at=tours_at,
        prospects_at=prospects_at,
        features=features,
        frames=config.frames,
    )


def _places(at: int, *sizes: int) -> list[int]:
    """Return where parts of these sizes begin one after another, -1 for those left out, and where the last one ends."""
    places = []
    for size in sizes:
        places.append(at if size else -1)
        at += size
    return [*places, at]


def tour_costs(layout: ObservationLayout, to_goal: float, to_mark: float) -> NDArray[np.float32] | None:
    """Return weights (F,) of the features of a move that charge each step beyond the shortest tours.

    Steps behind the best prospect by all that is in view cost as much as those of tours to the goal: of one kind alone,
    as a UAV drawn to two places at once may end up flying to and fro between them. None where neither is seen or they
    cost nothing.
    """
    if layout.tours_at == layout.prospects_at == -1 or to_goal == to_mark == 0.0:
        return None
    weights = np.zeros(layout.features, np.float32)
    if layout.tours_at >= 0:
        weights[layout.tours_at + TOURS.index("its steps beyond the shortest")] = -to_goal * BEYOND
        weights[layout.tours_at + TOURS.index("its steps beyond the shortest to 90 %")] = -to_mark * BEYOND
    if layout.prospects_at >= 0:
        weights[layout.prospects_at + PROSPECT.index("steps behind the best")] = -to_goal * BEYOND
    return weights


class Symmetries(NamedTuple):
    """Index tables: under symmetry g an array ``x`` becomes ``x[table[g]]``."""

    scene: NDArray[np.int64]
    """(8, S) for one scene."""
    moves: NDArray[np.int64]
    """(8, 4) for the rows of the move features."""
    action: NDArray[np.int64]
    """(8, 4) the move that each move turns into."""


def turned(array: NDArray[Any], symmetry: int) -> NDArray[Any]:
    """Return a (H, W) array under one of the eight symmetries: mirrored from 4 on, then turned."""
    return np.rot90(np.fliplr(array) if symmetry >= 4 else array, symmetry % 4)


def _turned_moves(symmetry: int) -> list[int]:
    """Return the move that each of the four moves turns into."""
    result = []
    for row, col in MOVES[:4]:
        marked = np.zeros((3, 3))
        marked[1 + row, 1 + col] = 1
        seen = np.argwhere(turned(marked, symmetry))[0] - 1
        result.append(int(np.flatnonzero((MOVES[:4] == seen).all(axis=1))[0]))
    return result


@lru_cache(maxsize=64)
def symmetries(config: ObservationConfig) -> Symmetries:
    """Return the tables of an observation."""
    layout = observation_layout(config)
    action = np.array([_turned_moves(g) for g in range(SYMMETRIES)])
    moves = np.argsort(action, axis=1)
    scene = np.tile(np.arange(layout.scene), (SYMMETRIES, 1))
    maps = [(start, config.crop) for start in layout.layers.tolist() if start >= 0]
    if layout.coarse_at >= 0:
        maps += [(layout.coarse_at + k * config.coarse**2, config.coarse) for k in range(2 + layout.coarse_mates)]
    for g in range(SYMMETRIES):
        for start, side in maps:
            cells = np.arange(start, start + side * side).reshape(side, side)
            scene[g, start : start + side * side] = turned(cells, g).ravel()
        if layout.sides_at >= 0:
            scene[g, layout.sides_at : layout.sides_at + 4] = layout.sides_at + moves[g]
    return Symmetries(scene=scene, moves=moves, action=action)
