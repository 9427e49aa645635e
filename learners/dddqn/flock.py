"""UAVs that learn: the columns of a world's batch, with what each must remember to observe."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.arrays import Mask
from indoor_explorers.env.scenario import Scenario
from indoor_explorers.env.state import End
from indoor_explorers.env.world import World
from indoor_explorers.learners.dddqn.observation import MOVE_FEATURES, SCENE, observe_all
from indoor_explorers.learners.dddqn.sensor import Scratch, scratch, sensor


class Flock:
    """Fly ``episodes`` episodes side by side; column b * team + n is UAV n of episode b, C columns in all."""

    def __init__(self, scenario: Scenario, episodes: int, next_seed: Callable[[], int]) -> None:
        self.world = World(scenario, episodes)
        self.columns = episodes * scenario.team
        self.scene = np.zeros((self.columns, SCENE), np.uint8)
        self.moves = np.zeros((self.columns, 4, len(MOVE_FEATURES)), np.float32)
        self._next_seed = next_seed
        for episode in range(episodes):
            self._begin(episode, next_seed())
        self.shape: tuple[int, int] = self.world.state.truth.shape[1:]
        self.noted = np.zeros((self.columns, *self.shape), np.uint8)
        self.visits = np.zeros((self.columns, *self.shape), np.uint8)
        self._sensor = sensor(scenario.lidar.range)
        self._scratch: Scratch = scratch(self.shape, self._sensor)

    def _begin(self, episode: int, seed: int) -> None:
        self.world.begin(episode, seed, index=seed % self.world.scenario.map.count)

    @property
    def over(self) -> Mask:
        """(C,) UAVs whose episode has ended."""
        return np.asarray(self.world.state.end.ravel() != End.FLYING)

    @property
    def terminal(self) -> Mask:
        """(C,) UAVs whose episode has ended for good, not for lack of steps."""
        end = self.world.state.end.ravel()
        return np.asarray((end != End.FLYING) & (end != End.BUDGET))

    def observe(self, columns: NDArray[np.int64]) -> None:
        """Refresh ``scene`` (C, 696) and ``moves`` (C, 4, 8) of some columns."""
        state = self.world.state
        observe_all(
            state.belief.reshape(self.columns, *self.shape),
            state.cell.reshape(self.columns, 2),
            self.noted,
            self.visits,
            columns,
            self._sensor,
            self._scratch,
            self.scene,
            self.moves,
        )

    def step(self, actions: NDArray[np.int64]) -> NDArray[np.float64]:
        """Make one move (C,) each; return the rewards (C,)."""
        self.world.step(actions.reshape(self.world.state.end.shape))
        return self.world.state.reward.ravel()

    def restart(self, episodes: NDArray[np.int64]) -> None:
        """Begin new episodes in place of these."""
        team = self.world.scenario.team
        for episode in episodes.tolist():
            self._begin(episode, self._next_seed())
            columns = slice(episode * team, (episode + 1) * team)
            self.noted[columns] = 0
            self.visits[columns] = 0

    def tensors(self) -> dict[str, NDArray[np.generic]]:
        """Return everything that :meth:`restore` needs, by name."""
        state = {f"world/{name}": array for name, array in self.world.state._asdict().items()}
        seeds = np.array([[seed >> 32, seed & 0xFFFFFFFF] for seed in self.world.seeds], np.int64)
        return state | {"flock/noted": self.noted, "flock/visits": self.visits, "flock/seeds": seeds}

    def restore(self, tensors: dict[str, NDArray[np.generic]]) -> None:
        """Go on exactly where :meth:`tensors` was taken."""
        for episode, (high, low) in enumerate(tensors["flock/seeds"].tolist()):
            self._begin(episode, (high << 32) | low)
        for name, array in self.world.state._asdict().items():
            array[...] = tensors[f"world/{name}"]
        self.noted[...] = tensors["flock/noted"]
        self.visits[...] = tensors["flock/visits"]
