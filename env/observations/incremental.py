"""The planes of ``channels`` for a whole batch, updated in place: a step repaints only the changed cells.

A world's discovery logs list the newly known cells, so the time of an update depends on their number and not on the
map. The planes equal those of :mod:`indoor_explorers.env.observations.planes`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import allocated
from indoor_explorers.env.grid.cells import FREE, MOVES, UNKNOWN
from indoor_explorers.env.grid.compiled import inner, kernel
from indoor_explorers.env.observations.planes import FRONTIER, FULL, MATES, PLANES, SELF, VISITED, codes_of
from indoor_explorers.env.search.frontiers import touches_unknown
from indoor_explorers.env.simulation.engine import Engine
from indoor_explorers.env.simulation.state import State
from indoor_explorers.env.simulation.world import World


class PlaneBuffers(NamedTuple):
    """The planes and the painted state."""

    planes: Annotated[NDArray[np.uint8], "B N C H W"]
    """The painted planes."""
    place: Annotated[NDArray[np.int64], "7"]
    """Index of each of :data:`PLANES` among the C planes, -1 for none."""
    begun: Annotated[NDArray[np.int64], "B"]
    """The world's count of episodes begun, see :attr:`World.begun`."""
    step: Annotated[NDArray[np.int64], "B"]
    """Steps flown of that episode."""
    known: Annotated[NDArray[np.int64], "B N"]
    """Painted entries of the agent's discovery log."""
    cell: Annotated[NDArray[np.int64], "B N 2"]
    """Cell in which the agent itself is marked."""
    mates: Annotated[NDArray[np.int64], "B N N"]
    """Flat cell in which each teammate is marked, -1 for none."""


class LivePlanes:
    """Observations of all agents of a world, (B, N, C, H, W) uint8; :meth:`update` repaints them."""

    def __init__(self, world: World, planes: Sequence[str] = PLANES) -> None:
        """Prepare for a world with episodes in it; ``planes`` are as for ``channels``."""
        self._world = world
        batch, team, height, width = world.state.belief.shape
        self._buffers = allocated(PlaneBuffers, B=batch, N=team, C=len(planes), H=height, W=width)
        for numbers in (self._buffers.place, self._buffers.begun, self._buffers.mates):
            numbers[:] = -1
        self._buffers.place[codes_of(planes)] = np.arange(len(planes))

    @property
    def planes(self) -> NDArray[np.uint8]:
        """(B, N, C, H, W) the agents' planes; the same array at each call, so copy it to keep it."""
        return self._buffers.planes

    def update(self) -> NDArray[np.uint8]:
        """Paint the changes since the last call and return :attr:`planes`."""
        self._world.in_slices(self._refresh)
        return self.planes

    def step(self, actions: NDArray[np.integer[Any]]) -> NDArray[np.uint8]:
        """Step the world with actions (B, N) and update in the same threads; return :attr:`planes`."""
        self._world.step(actions, self._refresh)
        return self.planes

    def _refresh(self, engine: Engine, first: int, last: int) -> None:
        _refresh(engine, self._world.begun, self._buffers, first, last)


@kernel()
def _refresh(engine: Engine, begun: np.ndarray, buffers: PlaneBuffers, first: int, last: int) -> None:
    state = engine.state
    for b in range(first, last):
        skipped = state.step[b] - buffers.step[b] > 1 or state.step[b] < buffers.step[b]
        anew = skipped or buffers.begun[b] != begun[b] or not engine.rules.exact_scans
        for n in range(state.end.shape[1]):
            if anew:
                _blank(state, buffers, b, n)
            _show_known(state, buffers, b, n)
            _show_self(state, buffers, b, n)
            _show_mates(state, buffers, b, n)
        buffers.begun[b] = begun[b]
        buffers.step[b] = state.step[b]


@inner()
def _blank(state: State, buffers: PlaneBuffers, b: int, n: int) -> None:
    """Paint an empty map, and the cells that the agent has been in."""
    height, width = state.truth.shape[1], state.truth.shape[2]
    buffers.known[b, n] = 0
    buffers.mates[b, n, :] = -1
    buffers.planes[b, n, :, :, :] = 0
    if buffers.place[UNKNOWN] >= 0:
        buffers.planes[b, n, buffers.place[UNKNOWN], :, :] = FULL
    if buffers.place[VISITED] >= 0:
        for row in range(height):
            for col in range(width):
                if state.visited[b, n, row, col]:
                    buffers.planes[b, n, buffers.place[VISITED], row, col] = FULL


@inner()
def _show_known(state: State, buffers: PlaneBuffers, b: int, n: int) -> None:
    """Paint the cells that are new in the discovery log, and the frontier around them."""
    height, width = state.truth.shape[1], state.truth.shape[2]
    unknown, frontier = buffers.place[UNKNOWN], buffers.place[FRONTIER]
    for k in range(buffers.known[b, n], state.known[b, n]):
        row, col = divmod(state.discovery_log[b, n, k], width)
        if unknown >= 0:
            buffers.planes[b, n, unknown, row, col] = 0
        place = buffers.place[state.belief[b, n, row, col]]
        if place >= 0:
            buffers.planes[b, n, place, row, col] = FULL
        if frontier >= 0:
            for move in range(5):
                r, c = row + MOVES[move, 0], col + MOVES[move, 1]
                if 0 <= r < height and 0 <= c < width and state.belief[b, n, r, c] == FREE:
                    open_ = touches_unknown(state.belief[b, n], r, c)
                    buffers.planes[b, n, frontier, r, c] = FULL if open_ else 0
    buffers.known[b, n] = state.known[b, n]


@inner()
def _show_self(state: State, buffers: PlaneBuffers, b: int, n: int) -> None:
    row, col = state.believed_cell[b, n, 0], state.believed_cell[b, n, 1]
    if buffers.place[SELF] >= 0:
        buffers.planes[b, n, buffers.place[SELF], buffers.cell[b, n, 0], buffers.cell[b, n, 1]] = 0
        buffers.planes[b, n, buffers.place[SELF], row, col] = FULL
    if buffers.place[VISITED] >= 0:
        buffers.planes[b, n, buffers.place[VISITED], row, col] = FULL
    buffers.cell[b, n, 0], buffers.cell[b, n, 1] = row, col


@inner()
def _show_mates(state: State, buffers: PlaneBuffers, b: int, n: int) -> None:
    """Mark each teammate in its last received cell, with :data:`FULL` minus the age of that position, at least 1."""
    width, place = state.truth.shape[2], buffers.place[MATES]
    if place < 0:
        return
    for mate in range(state.end.shape[1]):
        if buffers.mates[b, n, mate] >= 0:
            row, col = divmod(buffers.mates[b, n, mate], width)
            buffers.planes[b, n, place, row, col] = 0
    for mate in range(state.end.shape[1]):
        if state.last_received_step[b, n, mate] >= 0:
            row, col = state.last_received_cell[b, n, mate, 0], state.last_received_cell[b, n, mate, 1]
            fresh = max(FULL - (state.step[b] - state.last_received_step[b, n, mate]), 1)
            buffers.planes[b, n, place, row, col] = max(fresh, buffers.planes[b, n, place, row, col])
            buffers.mates[b, n, mate] = row * width + col
