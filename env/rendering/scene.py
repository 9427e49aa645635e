"""The content of a picture of an episode, as plain arrays that are independent of the world they came from."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.cells import MOVES
from indoor_explorers.env.grid.levels import Levels
from indoor_explorers.env.policies.explanation import Explanation
from indoor_explorers.env.rendering.level_grid import LevelGrid
from indoor_explorers.env.sensing.field_of_view import least_cosine
from indoor_explorers.env.sensing.lidar import LidarModel, lidar_model, new_scan, visible_cells
from indoor_explorers.env.simulation.custom_models import custom_scan
from indoor_explorers.env.simulation.state import End
from indoor_explorers.env.simulation.world import World

#: Positions that a trail holds at least and at most; between them, twice the sum of the map's sides.
TRAIL_LENGTHS = (40, 400)


class Told(NamedTuple):
    """Why a UAV flies where it does."""

    agent: int
    """Its number."""
    explanation: Explanation | None
    """Of its last move; None if the pilot cannot tell."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """The drawn state of an episode with N UAVs on a map of H x W cells; arrays may be live, copy them to keep them.

    Of several levels, H x W are those of their plane (:mod:`indoor_explorers.env.grid.levels`).
    """

    truth: NDArray[np.uint8]
    """(H, W) the true map: 1 free, 2 occupied."""
    union: NDArray[np.uint8]
    """(H, W) the union of the team's maps: 0 unknown, 1 free, 2 occupied."""
    beliefs: NDArray[np.uint8]
    """(N, H, W) the map of each UAV."""
    in_view: Mask
    """(N, H, W) cells each UAV's lidar sees now; none once the UAV has ended."""
    trails: NDArray[np.int64]
    """(K, N, 2) the cells of each UAV in the last K steps, the present one last."""
    ends: NDArray[np.uint8]
    """(N,) :class:`End` of each UAV."""
    linked: Mask
    """(N, N) UAVs in direct radio contact."""
    heard_cell: NDArray[np.int64]
    """(N, N, 2) the cell of UAV j that UAV i last received."""
    heard_age: NDArray[np.int64]
    """(N, N) its age in steps; -1 for never."""
    step: int
    """Steps flown."""
    budget: int
    """Steps of the whole episode."""
    coverage: float
    """Share of the cells to explore that the team knows together."""
    lidar_range: float
    """Lidar range in cells."""
    radio: tuple[str, float] = ("none", 0.0)
    """Radio model and range in cells; the reach of ``square`` and ``disc`` is drawn."""
    base: tuple[int, int] | None = None
    """(row, column) of the home base; None where there is none."""
    base_coverage: float = 0.0
    """Share of the cells to explore that the base knows."""
    base_linked: Mask | None = None
    """(N,) the UAVs that a link to the base is drawn from, see :func:`base_links`; None where there is none."""
    prior: NDArray[np.uint8] | None = None
    """(H, W) the prior map: 1 free, 2 occupied; None where there is none."""
    title: str = ""
    """Stands in the caption."""
    told: Told | None = None
    """Which UAV is explained, and what its pilot tells; None for none."""
    level_count: int = 1
    """Levels of the map."""

    @property
    def shape(self) -> tuple[int, int]:
        """(H, W) of the map in cells."""
        return (self.truth.shape[0], self.truth.shape[1])

    @property
    def grid(self) -> LevelGrid:
        """Where the cells are in the picture."""
        return LevelGrid.of(Levels.of(self.shape, self.level_count))

    @property
    def team(self) -> int:
        """UAVs in the team."""
        return len(self.ends)

    @property
    def cells(self) -> NDArray[np.int64]:
        """(N, 2) row and column of each UAV now."""
        return np.asarray(self.trails[-1])


class Trails:
    """Keep the cells of the UAVs of one episode in its last steps."""

    def __init__(self, shape: tuple[int, int]) -> None:
        least, most = TRAIL_LENGTHS
        self._cells: deque[NDArray[np.int64]] = deque(maxlen=min(max(2 * sum(shape), least), most))

    def restart(self, cells: NDArray[np.int64]) -> None:
        """Remove everything and start at ``cells`` (N, 2)."""
        self._cells.clear()
        self.add(cells)

    def add(self, cells: NDArray[np.int64]) -> None:
        """Add the cells of the UAVs after a step, (N, 2)."""
        self._cells.append(cells.copy())

    @property
    def cells(self) -> NDArray[np.int64]:
        """(K, N, 2) positions, the present ones last."""
        return np.stack(self._cells)


def scene_of(world: World, episode: int, trails: Trails | None = None, title: str | None = None) -> Scene:
    """Return the scene of one episode now; the default ``title`` is the scenario's name."""
    state, scenario = world.state, world.scenario
    heard_cell, heard_age = _heard(world, episode)
    base = state.base_cell[episode] if scenario.base.exists else None
    levels = Levels.of(state.truth.shape[1:], scenario.map.level_count)
    return Scene(
        truth=state.truth[episode],
        union=state.union[episode],
        beliefs=state.belief[episode],
        in_view=_in_view(world, episode),
        trails=state.cell[episode][None] if trails is None else trails.cells,
        ends=state.end[episode],
        linked=state.linked[episode],
        heard_cell=heard_cell,
        heard_age=heard_age,
        step=int(state.step[episode]),
        budget=int(state.budget[episode]),
        coverage=float(world.team_coverage[episode]),
        lidar_range=scenario.lidar.range,
        radio=(scenario.radio.model, scenario.radio.range),
        base=None if base is None else (base.item(0), base.item(1)),
        base_coverage=float(world.base_coverage[episode]),
        base_linked=None
        if base is None
        else base_links(
            state.linked[episode], state.base_contact[episode], levels.voxels(state.cell[episode]), levels.voxels(base)
        ),
        prior=world.prior(episode),
        title=scenario.name if title is None else title,
        level_count=levels.number,
    )


def with_base(linked: Mask, leads: Mask) -> Mask:
    """Return the links (N + 1, N + 1) of UAVs (N, N) and, last, of the home base to the UAVs ``leads`` (N,)."""
    linked = np.pad(linked, (0, 1))
    linked[-1, :-1] = linked[:-1, -1] = leads
    return linked


def base_links(linked: Mask, contact: Mask, cells: NDArray[np.int64], base: NDArray[np.int64]) -> Mask:
    """Return (N,) bool: the nearest UAV of each group in contact with the home base, from which a link is drawn.

    Args:
        linked: (N, N) UAVs in direct radio contact.
        contact: (N,) UAVs in contact with the base, directly or through others.
        cells: (N, D) of the UAVs, in two or three dimensions.
        base: (D,) cell of the base.

    """
    from scipy.sparse.csgraph import connected_components  # here, since it takes long to import

    groups = connected_components(linked, directed=False)[1]
    away = ((cells - base) ** 2).sum(axis=1)
    leads = np.zeros(len(cells), np.bool_)
    for group in np.unique(groups[contact]):
        members = np.flatnonzero(groups == group)
        leads[members[away[members].argmin()]] = True
    return leads


def _in_view(world: World, episode: int) -> Mask:
    truth = world.state.truth[episode]
    seen = np.zeros((world.scenario.team, *truth.shape), np.bool_)
    levels = world.scenario.map.level_count
    for n in np.flatnonzero(world.state.end[episode] == End.FLYING).tolist():
        row, col = world.state.cell[episode, n].tolist()
        lidar = world.scenario.lidar
        if lidar.custom is not None:
            seen[n] = custom_scan(lidar.custom, truth, (row, col), lidar.range)
        else:
            seen[n].flat[
                _seen_from(truth, row, col, lidar_model(lidar.range, lidar.model, levels, lidar.elevation))
            ] = True
        if (heading := world.view(episode, n).heading) is not None:
            seen[n] &= _is_ahead(truth.shape, (row, col), heading, lidar.field_of_view)
    return seen


def _seen_from(truth: NDArray[np.uint8], row: int, col: int, lidar: LidarModel) -> NDArray[np.int64]:
    """Return the flat indices of the cells that a lidar in a cell sees."""
    work = new_scan(lidar)
    return work.cells[: visible_cells(truth, row, col, lidar, work)]


def _is_ahead(shape: tuple[int, ...], cell: tuple[int, int], heading: int, degrees: float) -> Mask:
    """Return the (H, W) mask of the cells in a field of view of ``degrees``, which includes all neighbours."""
    rows, cols = np.indices(shape) - np.reshape(cell, (2, 1, 1))
    near = np.maximum(abs(rows), abs(cols)) <= 1
    return np.asarray(
        near | (rows * MOVES[heading, 0] + cols * MOVES[heading, 1] >= least_cosine(degrees) * np.hypot(rows, cols))
    )


def _heard(world: World, episode: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    team = world.scenario.team
    cell, age = np.zeros((team, team, 2), np.int64), np.full((team, team), -1, np.int64)
    for n in range(team):
        for mate in world.view(episode, n).mates:
            cell[n, mate.agent], age[n, mate.agent] = mate.cell, mate.age
    return cell, age
