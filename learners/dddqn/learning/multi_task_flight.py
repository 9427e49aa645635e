"""Multi-task flight: one vectorised flight for each of several scenarios, with the interface of a single one."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.dddqn.learning.vector_flight import VectorFlight
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.map_prior import MapPrior

#: Fewest episodes of each of several scenarios.
LEAST = 4


def shares(environments: int, tasks: int) -> list[int]:
    """Return the episodes of each task: ``environments`` divided evenly, at least four for each of several tasks."""
    if tasks == 1:
        return [environments]
    return [max(environments * (k + 1) // tasks - environments * k // tasks, LEAST) for k in range(tasks)]


class MultiTaskFlight:
    """Fly the episodes of several tasks in parallel; the columns of the first task come first, C in all.

    Maps, lidars, teams and radios may differ between tasks; observations have the same size for all of them.
    """

    def __init__(
        self,
        tasks: Sequence[Scenario],
        observation: ObservationConfig,
        prior: MapPrior,
        environments: int,
        next_seed: Callable[[], int],
    ) -> None:
        counts = shares(environments, len(tasks))
        self.flights = [
            VectorFlight(task, observation, prior, count, next_seed) for task, count in zip(tasks, counts, strict=True)
        ]
        self.columns = sum(flight.columns for flight in self.flights)
        self._ends = np.cumsum([flight.columns for flight in self.flights])[:-1]
        self.scene = np.concatenate([flight.scene for flight in self.flights])
        """(C, S) uint8, the latest scene."""
        self.scenes = np.concatenate([flight.scenes for flight in self.flights])
        """(C, I) uint8, the stacked scenes, latest first."""
        self.moves = np.concatenate([flight.moves for flight in self.flights])
        """(C, 4, F) float32, the latest move features."""
        self._share_views()

    def _share_views(self) -> None:
        """Let each flight write its observations into its columns of the common arrays, so that no tick copies them."""
        parts = (np.split(array, self._ends) for array in (self.scene, self.scenes, self.moves))
        for flight, scene, scenes, moves in zip(self.flights, *parts, strict=True):
            flight.scene, flight.scenes, flight.moves = scene, scenes, moves

    @property
    def over(self) -> Mask:
        """(C,) whether a UAV's episode has ended."""
        return np.concatenate([flight.over for flight in self.flights])

    @property
    def terminal(self) -> Mask:
        """(C,) whether a UAV's episode was terminated, not truncated by its budget."""
        return np.concatenate([flight.terminal for flight in self.flights])

    @property
    def age(self) -> NDArray[np.int64]:
        """(C,) steps since each UAV's episode began."""
        return np.concatenate([flight.age for flight in self.flights])

    @property
    def coverage(self) -> NDArray[np.float64]:
        """(C,) coverage of each UAV's team, as a share of the reachable cells."""
        return np.concatenate([flight.coverage for flight in self.flights])

    def observe(self) -> None:
        """Compute the observations of all UAVs; call it once per step."""
        for flight in self.flights:
            flight.observe(np.arange(flight.columns))

    def step(self, actions: NDArray[np.int64]) -> NDArray[np.float64]:
        """Make the moves ``actions`` (C,); return the rewards (C,)."""
        parts = np.split(actions, self._ends)
        return np.concatenate([flight.step(part) for flight, part in zip(self.flights, parts, strict=True)])

    def repeat(self, values: Sequence[float]) -> NDArray[np.float64]:
        """Return the values of the tasks repeated for their UAVs, (C,)."""
        return np.repeat(np.array(values), [flight.columns for flight in self.flights])

    def renew(self, over: Mask) -> list[int]:
        """Start new episodes in place of those whose UAVs are all ``over`` (C,); return the lengths of the old ones."""
        ended: list[int] = []
        for flight, part in zip(self.flights, np.split(over, self._ends), strict=True):
            episodes = np.flatnonzero(part.reshape(flight.world.state.end.shape).all(axis=1))
            ended += flight.world.state.step[episodes].tolist()
            flight.restart(episodes)
        return ended

    def tensors(self) -> dict[str, NDArray[np.generic]]:
        """Return everything that :meth:`restore` needs, by name."""
        parts = [(f"{place}/", flight.tensors()) for place, flight in enumerate(self.flights)]
        return {prefix + name: array for prefix, tensors in parts for name, array in tensors.items()}

    def restore(self, tensors: dict[str, NDArray[np.generic]]) -> None:
        """Restore the state that :meth:`tensors` returned."""
        for place, flight in enumerate(self.flights):
            prefix = f"{place}/"
            own = {name.removeprefix(prefix): array for name, array in tensors.items() if name.startswith(prefix)}
            flight.restore(own)
