"""Lidars and radios of plug-ins, called between the compiled parts of a step.

A lidar is a function of the true map (H, W), a cell (row, column) and the range in cells, which returns an (H, W) mask
of the cells seen. A radio is a function of the true map, the cells (N, 2) of all UAVs and the scenario's ``Radio``,
which returns an (N, N) symmetric mask of the pairs in contact. Both must depend on their arguments alone, so that an
episode is a function of its seed and actions; the world itself draws which contacts fail (``radio.loss``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import RunError, described
from indoor_explorers.env.grid.arrays import read_only
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.engine import Engine
from indoor_explorers.env.simulation.state import State
from indoor_explorers.env.simulation.step import begin_step, end_step, enter_scan, first_contacts


@dataclass(frozen=True)
class CustomModels:
    """The plug-ins of a scenario: at least one is not None."""

    scenario: Scenario
    lidar: Callable[..., Any] | None
    radio: Callable[..., Any] | None

    @classmethod
    def of(cls, scenario: Scenario) -> CustomModels | None:
        """Return the plug-ins of a scenario; None where it has none."""
        lidar, radio = scenario.lidar.custom, scenario.radio.custom
        return None if lidar is None and radio is None else cls(scenario, lidar, radio)

    def begin(self, engine: Engine, state: State, episodes: Sequence[int], seeds: Sequence[int]) -> None:
        """Make the first scans and contacts of episodes that have just begun."""
        for b in episodes:
            self._sense(engine, state, b)
            first_contacts(engine, b)

    def advance(self, engine: Engine, state: State, actions: NDArray[np.int64], first: int, last: int) -> None:
        """Advance episodes first to last - 1 by one step with actions (B, N), as ``advance`` of exact worlds does."""
        flying = np.zeros(len(state.end), np.bool_)
        begin_step(engine, actions, flying, first, last)
        for b in np.flatnonzero(flying).tolist():
            self._sense(engine, state, b)
        end_step(engine, flying, first, last)

    def _sense(self, engine: Engine, state: State, b: int) -> None:
        """Scan from newly entered cells, and determine the pairs in contact."""
        truth = read_only(state.truth[b])
        if self.lidar is not None:
            for agent, (row, col) in enumerate(state.cell[b].tolist()):
                if not state.visited[b, agent, row, col]:
                    seen = custom_scan(self.lidar, truth, (row, col), self.scenario.lidar.range)
                    enter_scan(engine, b, agent, np.flatnonzero(seen))
        if self.radio is not None:
            state.linked[b] = self._contacts(truth, state.cell[b])

    def _contacts(self, truth: NDArray[np.uint8], cells: NDArray[np.int64]) -> NDArray[np.bool_]:
        assert self.radio is not None
        pairs = _called(self.radio, "radio", truth, read_only(cells), self.scenario.radio)
        if pairs.shape != (len(cells),) * 2 or not np.array_equal(pairs, pairs.T):
            raise RunError(
                f"radio {self.scenario.radio.model!r}: expected a symmetric mask of shape {(len(cells),) * 2}, "
                f"got one of shape {pairs.shape}"
            )
        np.fill_diagonal(pairs, False)
        return pairs


def custom_scan(
    lidar: Callable[..., Any], truth: NDArray[np.uint8], cell: tuple[int, int], lidar_range: float
) -> NDArray[np.bool_]:
    """Return the (H, W) mask that a plug-in's lidar sees, with the own cell; raise :class:`RunError` if it fails."""
    seen = _called(lidar, "lidar", truth, cell, lidar_range)
    if seen.shape != truth.shape:
        raise RunError(f"lidar: expected an (H, W) mask of shape {truth.shape}, got one of shape {seen.shape}")
    seen[cell] = True
    return seen


def _called(plugin: Callable[..., Any], what: str, *arguments: Any) -> NDArray[np.bool_]:
    try:
        return np.array(plugin(*arguments), np.bool_)
    except Exception as error:
        raise RunError(f"{what} of a plug-in failed: {described(error)}") from error
