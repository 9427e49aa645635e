"""The learned map prior: the probability that an unknown cell is free and reachable, from the 7x7 cells around it.

Coverage counts such cells. The prior is a network with one hidden layer, fitted before the training to unknown cells of
the training maps (:mod:`indoor_explorers.learners.dddqn.learning.prior_fitting`). Without a known obstacle among the
7x7 cells the probability is 1.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.compiled import inner, leaf

#: Half width and side of the patch around a cell, in cells.
REACH, PATCH = 3, 7
#: Number of inputs: for every cell of the patch whether it is known free, known occupied, off the map.
INPUTS = 3 * PATCH * PATCH
#: Hidden units.
UNITS = 32
#: Code of cells off the map in a patch.
OFF_MAP = 3

Array = NDArray[np.float32]


class MapPrior(NamedTuple):
    """The network's arrays; without rows in ``hidden`` there is no prior, and every probability is 1."""

    hidden: Array
    """(147, U)."""
    hidden_bias: Array
    """(U,)."""
    out: Array
    """(U,)."""
    out_bias: Array
    """(1,)."""
    work: Array
    """(U,) scratch."""


def no_prior() -> MapPrior:
    """Return the empty prior, whose probabilities are 1."""
    return _arranged(np.zeros((0, UNITS)), np.zeros(UNITS), np.zeros(UNITS), np.zeros(1))


def _arranged(hidden: NDArray[Any], hidden_bias: NDArray[Any], out: NDArray[Any], out_bias: NDArray[Any]) -> MapPrior:
    first, second, third, fourth = (
        np.ascontiguousarray(array, np.float32) for array in (hidden, hidden_bias, out, out_bias)
    )
    return MapPrior(first, second, third, fourth, np.zeros(len(second), np.float32))


def prior_from(arrays: Mapping[str, NDArray[Any]]) -> MapPrior:
    """Return the prior with the arrays of a file, shaped as in :func:`prior_shapes`; empty if the file has none."""
    if "prior.hidden" not in arrays:
        return no_prior()
    return _arranged(arrays["prior.hidden"], arrays["prior.hidden_bias"], arrays["prior.out"], arrays["prior.out_bias"])


def prior_shapes(arrays: Mapping[str, NDArray[Any]]) -> dict[str, tuple[int, ...]]:
    """Return names and shapes of the prior's arrays in a weights file; none if it has no prior."""
    if not any(name.startswith("prior.") for name in arrays):
        return {}
    units = arrays["prior.hidden_bias"].size if "prior.hidden_bias" in arrays else UNITS
    sizes = {"hidden": (INPUTS, units), "hidden_bias": (units,), "out": (units,), "out_bias": (1,)}
    return {f"prior.{name}": size for name, size in sizes.items()}


def prior_arrays(prior: MapPrior) -> dict[str, Array]:
    """Return the prior's arrays by name; none for the empty prior."""
    if len(prior.hidden) == 0:
        return {}
    return {f"prior.{name}": array for name, array in prior._asdict().items() if name != "work"}


@leaf()
def write_patch(belief: np.ndarray, row: int, col: int, out: np.ndarray) -> int:
    """Write the 7x7 cells around a cell into ``out`` (49,) uint8; return how many of them are known obstacles."""
    height, width = belief.shape
    obstacles, at = 0, 0
    for r in range(row - REACH, row + REACH + 1):
        for c in range(col - REACH, col + REACH + 1):
            inside = 0 <= r < height and 0 <= c < width
            out[at] = belief[r, c] if inside else OFF_MAP
            obstacles += out[at] == OCCUPIED
            at += 1
    return obstacles


@inner()
def _judge(patch: np.ndarray, prior: MapPrior) -> float:
    """Return the log-odds that the cell in the middle of a patch is free and reachable."""
    units = prior.work.shape[0]
    for u in range(units):
        prior.work[u] = prior.hidden_bias[u]
    for k in range(PATCH * PATCH):
        if patch[k] != UNKNOWN:
            row = prior.hidden[(patch[k] - 1) * PATCH * PATCH + k]
            for u in range(units):
                prior.work[u] += row[u]
    odds = prior.out_bias[0]
    for u in range(units):
        odds += max(prior.work[u], np.float32(0.0)) * prior.out[u]
    return float(odds)


@leaf()
def write_chances(belief: np.ndarray, prior: MapPrior, patch: np.ndarray, box: np.ndarray, chance: np.ndarray) -> None:
    """Write the probability of each unknown cell to ``chance`` (H, W) uint8, 255 standing for 1; 0 for known cells.

    Only cells whose patch touches ``box`` (top, left, bottom, right) are written. ``patch`` (49,) uint8 is scratch.
    """
    height, width = belief.shape
    for r in range(max(box[0] - REACH, 0), min(box[2] + REACH, height)):
        for c in range(max(box[1] - REACH, 0), min(box[3] + REACH, width)):
            if belief[r, c] != UNKNOWN:
                chance[r, c] = 0
            elif prior.hidden.shape[0] == 0 or write_patch(belief, r, c, patch) == 0:
                chance[r, c] = 255
            else:
                chance[r, c] = int(255.0 / (1.0 + np.exp(-_judge(patch, prior))) + 0.5)


#: Probability, times 255, below which an unknown cell is assumed to be an obstacle.
UNLIKELY = 40


@leaf()
def assume_obstacles(belief: np.ndarray, chance: np.ndarray, out: np.ndarray) -> bool:
    """Write a belief with the assumed obstacles into ``out`` (H, W); return whether any obstacles are known.

    ``chance`` (H, W) uint8 is the map prior's probability of the unknown cells, 255 standing for 1.
    """
    any_known = False
    for r in range(belief.shape[0]):
        for c in range(belief.shape[1]):
            unlikely = belief[r, c] == UNKNOWN and chance[r, c] < UNLIKELY
            any_known |= belief[r, c] == OCCUPIED
            out[r, c] = OCCUPIED if unlikely else belief[r, c]
    return any_known
