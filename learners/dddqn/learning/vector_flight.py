"""Vectorised flight: all UAVs of a batch of episodes as columns, with the memory that their observations need."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask, read_only
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.state import End
from indoor_explorers.env.simulation.world import World
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import observation_layout, stacked
from indoor_explorers.learners.dddqn.observation.map_prior import MapPrior
from indoor_explorers.learners.dddqn.observation.memory import new_memory
from indoor_explorers.learners.dddqn.observation.observe import observation_context, observe
from indoor_explorers.learners.dddqn.observation.uav import Known
from indoor_explorers.learners.sessions.worlds import begin, restore_world, world_tensors


class VectorFlight:
    """Fly ``episodes`` episodes in parallel; column b * team + n is UAV n of episode b, C columns in all."""

    def __init__(
        self,
        scenario: Scenario,
        observation: ObservationConfig,
        prior: MapPrior,
        episodes: int,
        next_seed: Callable[[], int],
    ) -> None:
        layout = observation_layout(observation)
        self.world = World(scenario, episodes)
        self.columns = episodes * scenario.team
        self.scene = np.zeros((self.columns, layout.scene), np.uint8)
        """(C, S) uint8, the latest scene."""
        self.scenes = np.zeros((self.columns, layout.inputs), np.uint8)
        """(C, I) uint8, the stacked scenes, latest first; early in an episode its first scene is repeated."""
        self.moves = np.zeros((self.columns, 4, layout.features), np.float32)
        """(C, 4, F) float32, the latest move features."""
        self._next_seed = next_seed
        self._begin(list(range(episodes)))
        self.shape: tuple[int, int] = self.world.state.truth.shape[1:]
        self.memory = new_memory(self.columns, self.shape, observation, scenario.team)
        self._context = observation_context(observation, self.shape, scenario, prior)
        self._agent = np.tile(np.arange(scenario.team), episodes)

    def _begin(self, episodes: list[int]) -> None:
        """Begin episodes: all at once, or one by one in a scenario with several map files."""
        seeds = [self._next_seed() for _ in episodes]
        if self.world.scenario.map.count == 1:
            self.world.restart(episodes, seeds)
            return
        for episode, seed in zip(episodes, seeds, strict=True):
            begin(self.world, episode, seed)

    @property
    def over(self) -> Mask:
        """(C,) whether a UAV's episode has ended."""
        return np.asarray(self.world.state.end.ravel() != End.FLYING)

    @property
    def terminal(self) -> Mask:
        """(C,) whether a UAV's episode was terminated, not truncated by its budget."""
        end = self.world.state.end.ravel()
        return np.asarray((end != End.FLYING) & (end != End.BUDGET))

    @property
    def age(self) -> NDArray[np.int64]:
        """(C,) steps since each UAV's episode began."""
        return np.repeat(self.world.state.step, self.world.scenario.team)

    @property
    def coverage(self) -> NDArray[np.float64]:
        """(C,) coverage of each UAV's team, as a share of the reachable cells."""
        return np.repeat(self.world.team_coverage, self.world.scenario.team)

    def _known(self) -> Known:
        state, team = self.world.state, self.world.scenario.team
        heard = state.last_received_step.reshape(self.columns, team)
        steps = self.age
        return Known(
            read_only(state.belief.reshape(self.columns, *self.shape)),
            state.believed_cell.reshape(self.columns, 2),
            state.last_received_cell.reshape(self.columns, team, 2),
            np.where(heard >= 0, steps[:, None] - heard, -1),
            self._agent,
            steps / np.repeat(state.budget, team),
        )

    def observe(self, columns: NDArray[np.int64]) -> None:
        """Compute ``scene``, ``scenes`` and ``moves`` of ``columns`` (K,); call it once per step."""
        observe(self._known(), self.memory, columns, self._context, self.scene, self.moves)
        self.scenes[columns] = stacked(self.scene[columns], self.scenes[columns], self.age[columns] == 0)

    def step(self, actions: NDArray[np.int64]) -> NDArray[np.float64]:
        """Make the moves ``actions`` (C,); return the rewards (C,)."""
        self.memory.aim(self.world.state.believed_cell.reshape(self.columns, 2), actions)
        self.world.step(actions.reshape(self.world.state.end.shape))
        return self.world.state.reward.ravel()

    def restart(self, episodes: NDArray[np.int64]) -> None:
        """Start new episodes in place of ``episodes`` (E,)."""
        if len(episodes) == 0:
            return
        team = self.world.scenario.team
        self._begin(episodes.tolist())
        self.memory.forget((episodes[:, None] * team + np.arange(team)).ravel().tolist())

    def tensors(self) -> dict[str, NDArray[np.generic]]:
        """Return everything that :meth:`restore` needs, by name."""
        memory = {f"memory/{name}": array for name, array in self.memory._asdict().items()}
        return world_tensors(self.world) | memory | {"flock/scenes": self.scenes}

    def restore(self, tensors: dict[str, NDArray[np.generic]]) -> None:
        """Restore the state that :meth:`tensors` returned."""
        restore_world(tensors, self.world)
        self.scenes[...] = tensors["flock/scenes"]
        for name, array in self.memory._asdict().items():
            array[...] = tensors[f"memory/{name}"]
