"""Vectorised flight: a batch of episodes, and the stacked images of each UAV that the network flies."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.state import End
from indoor_explorers.env.simulation.world import World
from indoor_explorers.learners.sessions.worlds import begin, restore_world, world_tensors
from indoor_explorers.learners.thesis.observation import centre_all, paint_all


class ImageFlight:
    """Fly ``episodes`` episodes in parallel; column b * team + n is UAV n of episode b, C columns in all."""

    def __init__(
        self,
        scenario: Scenario,
        episodes: int,
        next_seed: Callable[[], int],
        *,
        frames: int,
        identity: bool,
        pilots: Sequence[int],
        centred: bool = False,
    ) -> None:
        self.world = World(scenario, episodes)
        self.columns = episodes * scenario.team
        self.pilots = np.asarray(pilots)
        """Numbers of the UAVs that the network flies; only their images are kept."""
        self._next_seed, self._identity = next_seed, identity
        for episode in range(episodes):
            begin(self.world, episode, next_seed())
        height, width = self.world.state.truth.shape[1:]
        self._centred = centred
        self.shape: tuple[int, int] = (2 * height - 1, 2 * width - 1) if centred else (height, width)
        self._painted = np.zeros((self.columns, height, width), np.uint8)
        self.images = np.zeros((self.columns, frames, *self.shape), np.uint8)
        """(C, K, H, W) uint8 codes, the latest image last."""
        self._draw_first(self.columns_of(np.arange(episodes)))

    def columns_of(self, episodes: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the columns (C,) of the UAVs that the network flies in ``episodes`` (E,)."""
        return np.asarray((episodes[:, None] * self.world.scenario.team + self.pilots).ravel())

    def _draw_first(self, columns: NDArray[np.int64]) -> None:
        self.images[columns] = self._draw(columns)[:, None]

    def _draw(self, columns: NDArray[np.int64]) -> NDArray[np.uint8]:
        state, team = self.world.state, self.world.scenario.team
        heard = state.last_received_step, state.last_received_cell
        paint_all(state.belief, state.believed_cell, *heard, self._identity, columns, team, self._painted)
        if not self._centred:
            return self._painted[columns]
        images = np.empty((len(columns), *self.shape), np.uint8)
        centre_all(self._painted, state.believed_cell.reshape(-1, 2), columns, images)
        return images

    @property
    def end(self) -> NDArray[np.uint8]:
        """(C,) :class:`End` of each UAV; :attr:`End.FLYING` while it flies."""
        return self.world.state.end.ravel()

    @property
    def over(self) -> Mask:
        """(B,) whether all UAVs of an episode have ended."""
        return np.asarray((self.world.state.end != End.FLYING).all(axis=1))

    def step(self, actions: NDArray[np.int64], columns: NDArray[np.int64]) -> NDArray[np.uint8]:
        """Make the moves ``actions`` (C,); return the images of ``columns`` (P,) before and after, (P, K + 1, H, W)."""
        before = self.images[columns]
        self.world.step(actions.reshape(self.world.state.end.shape))
        seen = np.concatenate([before, self._draw(columns)[:, None]], axis=1)
        self.images[columns] = seen[:, 1:]
        return seen

    def restart(self, episodes: NDArray[np.int64]) -> None:
        """Start new episodes in place of ``episodes`` (E,)."""
        for episode in episodes.tolist():
            begin(self.world, episode, self._next_seed())
        self._draw_first(self.columns_of(episodes))

    def tensors(self) -> dict[str, NDArray[Any]]:
        """Return everything that :meth:`restore` needs, by name."""
        return world_tensors(self.world) | {"fleet/images": self.images}

    def restore(self, tensors: dict[str, NDArray[Any]]) -> None:
        """Restore the state that :meth:`tensors` returned."""
        restore_world(tensors, self.world)
        self.images[...] = tensors["fleet/images"]
