"""The layout of an observation, and its symmetries.

An observation has two parts. ``scene`` (S,) uint8, 255 standing for 1: the layers of the fine map, the coarse map's
unknown and known free cells (and teammates, if the fine map shows them), the four sides, identity, progress. ``moves``
(4, F) float32: for each move, whether it is blocked and the enabled features.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.cells import MOVES
from indoor_explorers.learners.dddqn.observation.config import LAYERS, ObservationConfig

#: Number of symmetries of the grid, rotations and reflections; number 0 is the identity.
SYMMETRIES = 8
#: Number of different identities; in larger teams several UAVs share one.
IDENTITIES = 8
#: Number of progress inputs.
PROGRESS = 3
#: Features of each move, by the setting that enables them; the first is always there.
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

#: Steps beyond the shortest tour, or behind the best candidate, at which that feature is 1.
BEYOND = 8.0
#: Delay beyond the least at which that feature is 1.
DELAYS = 200.0


class ObservationLayout(NamedTuple):
    """Offsets and sizes as plain numbers for compiled code; an offset of -1 means that the part is left out."""

    crop: int
    """Side of the fine map in pixels."""
    coarse: int
    """Side of the coarse map in blocks."""
    layers: NDArray[np.int64]
    """(8,) offsets in the scene of :data:`indoor_explorers.learners.dddqn.observation.config.LAYERS`."""
    coarse_at: int
    """Offset of the coarse map in the scene; so for the next parts."""
    coarse_mates: bool
    """Whether the coarse map shows teammates."""
    sides_at: int
    identity_at: int
    progress_at: int
    scene: int
    """Size of one scene, S."""
    gains_at: int
    """Offset of the gains among the features of a move; so for the next parts."""
    visits_at: int
    tours_at: int
    prospects_at: int
    features: int
    """Number of features of a move, F."""
    frames: int
    """Number of stacked scenes."""

    @property
    def inputs(self) -> int:
        """Size of all stacked scenes together."""
        return self.scene * self.frames


@lru_cache(maxsize=64)
def observation_layout(config: ObservationConfig) -> ObservationLayout:
    """Return the layout of an observation."""
    at, layers = 0, np.full(len(LAYERS), -1)
    for layer in config.layers:
        layers[LAYERS.index(layer)], at = at, at + config.crop**2
    mates = "mates" in config.layers or "mates_past" in config.layers
    scene = _offsets(
        at, (2 + mates) * config.coarse**2, 4 * config.sides, IDENTITIES * config.identity, PROGRESS * config.progress
    )
    features = _offsets(
        len(BLOCKED),
        len(GAINS) * config.gains,
        len(VISITS) * config.visits,
        len(TOURS) * config.tours,
        len(PROSPECTS) * len(PROSPECT) * config.prospects,
    )
    layers.setflags(write=False)
    return ObservationLayout._make(
        [config.crop, config.coarse, layers, scene[0], mates, *scene[1:], *features, config.frames]
    )


def _offsets(at: int, *sizes: int) -> list[int]:
    """Return the offsets of consecutive parts of these sizes, -1 for empty ones, and the end of the last part."""
    ends = list(accumulate(sizes, initial=at))
    return [end if size else -1 for end, size in zip(ends, sizes, strict=False)] + ends[-1:]


def tour_costs(
    layout: ObservationLayout, to_goal: float, to_mark: float, *, kinds: int = 1
) -> NDArray[np.float32] | None:
    """Return weights (F,) of a move's features that charge each step beyond the shortest tours.

    A step beyond the shortest tour to the goal costs ``to_goal``, one beyond the shortest tour to 90 % ``to_mark``. A
    step behind the best candidate costs ``to_goal``, divided among the first ``kinds`` of candidates. None if the
    observation has neither feature, or if both costs are 0.
    """
    if layout.tours_at == layout.prospects_at == -1 or to_goal == to_mark == 0.0:
        return None
    weights = np.zeros(layout.features, np.float32)
    if layout.tours_at >= 0:
        weights[layout.tours_at + TOURS.index("its steps beyond the shortest")] = -to_goal * BEYOND
        weights[layout.tours_at + TOURS.index("its steps beyond the shortest to 90 %")] = -to_mark * BEYOND
    if layout.prospects_at >= 0:
        behind = layout.prospects_at + PROSPECT.index("steps behind the best")
        weights[behind : behind + kinds * len(PROSPECT) : len(PROSPECT)] = -to_goal * BEYOND / kinds
    return weights


#: Cost of a delay of :data:`DELAYS` beyond the least, where a step beyond the shortest tour costs 1: it decides between
#: equals.
TIE = 0.01


def search_costs(layout: ObservationLayout, delay: float = 0.0) -> NDArray[np.float32] | None:
    """Return weights (F,) of a move's features that follow the tours or candidates alone; None if there are none.

    A step beyond the shortest tour costs 1, each step for which a cell is unseen longer than in the tour of least delay
    ``delay``, at least so much that it decides between equally short tours.
    """
    weights = tour_costs(layout, 1.0, 0.0)
    if weights is not None and layout.tours_at >= 0:
        weights[layout.tours_at + TOURS.index("its delay beyond the least")] = -max(TIE, delay * DELAYS)
    return weights


def move_parts(layout: ObservationLayout, moves: NDArray[np.float32]) -> dict[str, NDArray[np.float32]]:
    """Return the planner features of the moves (4, F) that say most, (4,) each, by name; none for the map alone."""
    parts = {}
    if layout.tours_at >= 0:
        for name in ("its steps beyond the shortest", "its steps beyond the shortest to 90 %"):
            parts[name.replace("its", "tour's")] = BEYOND * moves[:, layout.tours_at + TOURS.index(name)]
    if layout.prospects_at >= 0:
        behind = "steps behind the best"
        parts[behind + " candidate"] = BEYOND * moves[:, layout.prospects_at + PROSPECT.index(behind)]
    if layout.gains_at >= 0:
        parts["gain there"] = moves[:, layout.gains_at + GAINS.index("gain there")]
    return parts


class Symmetries(NamedTuple):
    """Index tables: under symmetry g an array ``x`` becomes ``x[table[g]]``."""

    scene: NDArray[np.int64]
    """(8, S) for one scene."""
    moves: NDArray[np.int64]
    """(8, 4) for the rows of the move features."""
    action: NDArray[np.int64]
    """(8, 4) the image of each move."""


def turned(array: NDArray[Any], symmetry: int) -> NDArray[Any]:
    """Return an array (H, W) under one of the eight symmetries: symmetries 4 to 7 mirror it, then all rotate it."""
    return np.rot90(np.fliplr(array) if symmetry >= 4 else array, symmetry % 4)


def _turned_moves(symmetry: int) -> list[int]:
    """Return the images of the four moves under a symmetry."""
    result = []
    for row, col in MOVES[:4]:
        marked = np.zeros((3, 3))
        marked[1 + row, 1 + col] = 1
        seen = np.argwhere(turned(marked, symmetry))[0] - 1
        result.append(int(np.flatnonzero((MOVES[:4] == seen).all(axis=1))[0]))
    return result


@lru_cache(maxsize=64)
def symmetries(config: ObservationConfig) -> Symmetries:
    """Return the index tables of an observation's symmetries."""
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


def stacked(scene: NDArray[np.uint8], scenes: NDArray[np.uint8], first: Mask) -> NDArray[np.uint8]:
    """Push new scenes (K, S) onto stacked ones (K, I), latest first; the ``first`` (K,) of an episode is repeated."""
    if scene.shape == scenes.shape:
        return scene
    frames = scenes.shape[1] // scene.shape[1]
    later = np.concatenate([scene, scenes[:, : -scene.shape[1]]], axis=1)
    return np.where(first[:, None], np.tile(scene, (1, frames)), later)
