"""The log of a batch of running episodes: every step is written for the whole batch at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import World
from indoor_explorers.evaluation.harness.episodes.steps import Steps, covered_columns, step_type

#: Initial capacity in steps; it doubles whenever it is full.
CAPACITY = 256


class Log:
    """Logs a batch of B episodes of N UAVs from their start; ``running`` (B,) says which are not over."""

    def __init__(self, world: World) -> None:
        batch, team = world.state.end.shape
        self._world = world
        self._team, self._columns = team, covered_columns(team)
        self._step = 0
        self._rows = np.zeros((batch, CAPACITY), step_type(team, world.scenario.base.exists))
        self.flown_steps = np.zeros((batch, team), np.int64)
        """(B, N) steps that each UAV flew."""
        self._ages = np.zeros(batch)
        self.running = np.ones(batch, np.bool_)
        self._steps = np.zeros(batch, np.int64)
        self._log_state()

    def add(self, actions: NDArray[np.int64], seconds: NDArray[np.float64]) -> None:
        """Log the step just made: (B, N) actions, and the (B,) seconds of their decisions."""
        if self._step + 1 == self._rows.shape[1]:
            self._rows = np.concatenate((self._rows, np.zeros_like(self._rows)), axis=1)
        self._step += 1
        self._steps[self.running] = self._step
        self.latest["actions"] = actions
        self.latest["seconds"] = self._rows["seconds"][:, self._step - 1] + seconds
        self._log_state()

    @property
    def latest(self) -> NDArray[np.void]:
        """(B,) rows of the step just made, or of the start."""
        return self._rows[:, self._step]

    def _log_state(self) -> None:
        state, rows, t = self._world.state, self.latest, self._step
        scenario, (own, base, seen) = self._world.scenario, self._columns
        rows["covered"][:, 0] = state.base_covered if scenario.base.must_return else state.team_covered
        rows["covered"][:, own] = state.covered
        if scenario.base.exists:
            rows["covered"][:, base] = state.base_covered
            rows["covered"][:, seen] = state.team_covered
        rows["cells"] = state.cell
        if self._team > 1:
            rows["sent"] = state.sent_bytes.sum(axis=1)
            self._ages += (t - np.maximum(state.last_received_step, 0)).sum(axis=(1, 2)) * self.running
        flying = self._world.flying
        self.flown_steps += flying
        self.running &= flying.any(axis=1)

    def steps(self, episode: int) -> Steps:
        """Return what was logged of one episode up to its end."""
        return Steps.of(self._rows[episode, : self._steps[episode] + 1])

    def age(self, episode: int) -> float | None:
        """Return the mean age of information of an episode in steps, over pairs and steps; None for one UAV."""
        if self._team == 1:
            return None
        last = int(self._steps[episode])
        own = self._team * last * (last + 1) / 2  # the entry of a UAV for itself grows by one a step
        pairs = self._team * (self._team - 1)
        return float((self._ages[episode] - own) / (pairs * (last + 1)))
