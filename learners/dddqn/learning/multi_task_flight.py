"""Multi-task flight: several scenarios side by side, a vectorised flight for each, which together look like one."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.dddqn.learning.vector_flight import VectorFlight
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.map_prior import MapPrior

#: Episodes that each of several scenarios has at least.
LEAST = 4


def shares(environments: int, tasks: int) -> list[int]:
    """Share ``environments`` out among tasks as evenly as possible, with at least four for each of several."""
    if tasks == 1:
        return [environments]
    return [max(environments * (k + 1) // tasks - environments * k // tasks, LEAST) for k in range(tasks)]


class MultiTaskFlight:
    """Fly the tasks' episodes side by side; the columns of the first task's flight come first, C in all.

    Maps, lidars, teams and radios may differ from task to task: an observation has one size for all of them.
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
        """(C, S) as last observed."""
        self.scenes = np.concatenate([flight.scenes for flight in self.flights])
        """(C, I) the latest scenes, latest first."""
        self.moves = np.concatenate([flight.moves for flight in self.flights])
        """(C, 4, F) as last observed."""
        self._share_views()

    def _share_views(self) -> None:
        """Let each flight observe into its own columns of the common arrays, so that nothing is copied in a tick."""
        parts = (np.split(array, self._ends) for array in (self.scene, self.scenes, self.moves))
        for flight, scene, scenes, moves in zip(self.flights, *parts, strict=True):
            flight.scene, flight.scenes, flight.moves = scene, scenes, moves

    @property
    def over(self) -> Mask:
        """(C,) UAVs whose episode has ended."""
        return np.concatenate([flight.over for flight in self.flights])

    @property
    def terminal(self) -> Mask:
        """(C,) UAVs whose episode has ended for good, not for lack of steps."""
        return np.concatenate([flight.terminal for flight in self.flights])

    @property
    def age(self) -> NDArray[np.int64]:
        """(C,) steps since each UAV's episode began."""
        return np.concatenate([flight.age for flight in self.flights])

    @property
    def coverage(self) -> NDArray[np.float64]:
        """(C,) share of the reachable cells that each UAV's team knows."""
        return np.concatenate([flight.coverage for flight in self.flights])

    def observe(self) -> None:
        """Refresh what all UAVs observe; once a step."""
        for flight in self.flights:
            flight.observe(np.arange(flight.columns))

    def step(self, actions: NDArray[np.int64]) -> NDArray[np.float64]:
        """Make one move (C,) each; return the rewards (C,)."""
        parts = np.split(actions, self._ends)
        return np.concatenate([flight.step(part) for flight, part in zip(self.flights, parts, strict=True)])

    def repeat(self, values: Sequence[float]) -> NDArray[np.float64]:
        """Return one value for each task as one for each UAV (C,)."""
        return np.repeat(np.array(values), [flight.columns for flight in self.flights])

    def renew(self, over: Mask) -> list[int]:
        """Begin new episodes in place of those whose UAVs are all ``over`` (C,); return the steps that they took."""
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
        """Go on exactly where :meth:`tensors` was taken."""
        for place, flight in enumerate(self.flights):
            prefix = f"{place}/"
            own = {name.removeprefix(prefix): array for name, array in tensors.items() if name.startswith(prefix)}
            flight.restore(own)
