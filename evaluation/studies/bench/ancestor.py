"""The step of the predecessors in plain Python and numpy, which the compiled world is compared with.

It is written from the descriptions of MarsExplorer (Koutras et al. 2021, doi:10.3390/electronics10222751) and of
IndoorExplorers, the thesis that this project grew out of, and has no code of theirs. It works as they do: one episode,
Python loops over UAVs, a lidar of 32 rays with 200 samples each at every step, copies of whole maps to find new cells,
and whole maps merged between UAVs in radio contact. Drawing, image observations, the stuck rule and prompts are left
out, so it is faster than they are, and ratios to it are not exaggerated. Walls cost a step, as in the worlds that it
is compared with; the caller gives the order of moves.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import Scenario, World
from indoor_explorers.env.grid.cells import OCCUPIED
from indoor_explorers.evaluation.studies.bench.figure import median_of, seconds_of
from indoor_explorers.evaluation.studies.bench.worlds import random_moves

#: Values of the explored maps (thesis, Table 3.1); a UAV is its number, from 1.
UNKNOWN, EMPTY, OBSTACLE = 0.0, 0.3, 0.5
MOVES = ((1, 0), (0, -1), (-1, 0), (0, 1), (0, 0))
RAYS, SAMPLES = 32, 200
STEP, COLLISION, BONUS = -0.5, -400.0, 400.0

Map = NDArray[np.float64]


class Ancestor:
    """One room that a team explores.

    Args:
        solid: (H, W) bool, where obstacles are.
        cells: start cells of the UAVs.
        lidar_range: in cells.
        radio_range: in cells, the half side of a square around a UAV; None for no radio.
        goal: share of all cells that a UAV must know.
        budget: steps.

    """

    def __init__(
        self,
        solid: NDArray[np.bool_],
        cells: Sequence[tuple[int, int]],
        lidar_range: float,
        radio_range: float | None = None,
        goal: float = 1.0,
        budget: int = 400,
    ) -> None:
        self.truth: Map = np.where(solid, OBSTACLE, EMPTY)
        self.cells = list(cells)
        self.lidar_range, self.radio_range = lidar_range, radio_range
        self.goal, self.budget, self.flown = goal, budget, 0
        self.explored = [np.full(solid.shape, UNKNOWN) for _ in cells]
        angles = np.linspace(0, 2 * np.pi, RAYS, endpoint=False)
        self.directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        for agent in range(len(cells)):
            self._scan(agent)
        self._merge()

    def step(self, actions: Sequence[int], order: Sequence[int]) -> tuple[list[Map], list[float], list[bool]]:
        """Move the UAVs in an order, scan, merge; return the observations, rewards and ends of all UAVs."""
        before = [explored.copy() for explored in self.explored]
        rewards = [STEP] * len(self.cells)
        for agent in order:
            if not self._move(agent, actions[agent]):
                rewards[agent] += COLLISION
            self._scan(agent)
        self._merge()
        self.flown += 1
        over = []
        for agent, explored in enumerate(self.explored):
            rewards[agent] += np.count_nonzero(explored) - np.count_nonzero(before[agent])
            done = self.coverage(agent) >= self.goal
            rewards[agent] += BONUS * done
            over.append(bool(done or self.flown >= self.budget))
        return [self._observation(agent) for agent in range(len(self.cells))], rewards, over

    def coverage(self, agent: int) -> float:
        """Return the share of all cells that a UAV knows."""
        return np.count_nonzero(self.explored[agent]) / self.truth.size

    def _move(self, agent: int, action: int) -> bool:
        """Move a UAV unless a teammate is there; return False where a wall is."""
        row, col = np.add(self.cells[agent], MOVES[action]).tolist()
        height, width = self.truth.shape
        if not (0 <= row < height and 0 <= col < width) or self.truth[row, col] == OBSTACLE:
            return False
        if (row, col) not in self.cells:
            self.cells[agent] = (row, col)
        return True

    def _cells_along(self, origin: NDArray[np.int64], lengths: Map) -> NDArray[np.int64]:
        """Return the (32, 200, 2) cells that rays of (32,) lengths run through."""
        samples = np.linspace(np.broadcast_to(origin, (RAYS, 2)), origin + lengths[:, None] * self.directions, SAMPLES)
        cells = np.clip(np.rint(samples), 0, np.array(self.truth.shape) - 1)
        return cells.astype(np.int64).transpose(1, 0, 2)

    def _scan(self, agent: int) -> None:
        """Add the lidar scan of a UAV to its map; rays end half a cell behind the first obstacle."""
        origin = np.array(self.cells[agent])
        lengths = np.full(RAYS, float(self.lidar_range))
        for ray, way in enumerate(self._cells_along(origin, lengths)):
            hits = way[self.truth[way[:, 0], way[:, 1]] == OBSTACLE]
            if len(hits):
                lengths[ray] = min(np.linalg.norm(hits - origin, axis=1).min() + 0.5, self.lidar_range)
        seen = self._cells_along(origin, lengths).reshape(-1, 2)
        explored = self.explored[agent].copy()
        explored[seen[:, 0], seen[:, 1]] = self.truth[seen[:, 0], seen[:, 1]]
        self.explored[agent] = explored

    def _merge(self) -> None:
        """Give all UAVs of a connected component a copy of all that they know together."""
        if self.radio_range is None:
            return
        cells = np.array(self.cells)
        in_contact = np.abs(cells[:, None] - cells[None]).max(axis=2) <= self.radio_range
        left = set(range(len(cells)))
        while left:
            component, open_ = set[int](), [left.pop()]
            while open_:
                agent = open_.pop()
                component.add(agent)
                open_ += [mate for mate in np.flatnonzero(in_contact[agent]).tolist() if mate in left]
                left -= set(open_)
            merged = np.maximum.reduce([self.explored[agent] for agent in component])
            for agent in component:
                self.explored[agent] = merged.copy()

    def _observation(self, agent: int) -> Map:
        """Return a copy of a UAV's map with the UAV on it, and the teammates that it is in contact with."""
        observed = self.explored[agent].copy()
        for mate, cell in enumerate(self.cells):
            away = np.abs(np.subtract(cell, self.cells[agent])).max()
            if mate == agent or (self.radio_range is not None and away <= self.radio_range):
                observed[cell] = mate + 1
        return observed


def of_world(world: World) -> Ancestor:
    """Return an ancestor with the room and the start cells of a world's only episode."""
    task, state = world.scenario, world.state
    cells = [(row, col) for row, col in state.cell[0].tolist()]
    radio_range = task.radio.range if task.radio.model == "square" else None
    solid = state.truth[0] == OCCUPIED
    return Ancestor(solid, cells, task.lidar.range, radio_range, task.goal, int(state.budget[0]))


def ancestor_speed(task: Scenario, steps: int = 64) -> float:
    """Return the ancestor's agent-steps a second under random moves, without starts of episodes."""
    world, rng = World(task), np.random.default_rng(0)
    world.reset([0])
    actions = random_moves(1, task.team, steps)[:, 0].tolist()
    orders = [rng.permutation(task.team).tolist() for _ in actions]

    def fly() -> float:
        ancestor = of_world(world)
        return seconds_of(lambda: [ancestor.step(*both) for both in zip(actions, orders, strict=True)])

    return steps * task.team / median_of(fly)
