"""The log of a batch of running episodes: what is kept of every step, written for the whole batch at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import World

#: Steps for which room is made at first; the room doubles whenever it is full.
ROOM = 256


class Flown(NamedTuple):
    """What the log holds of one episode; shapes as in :class:`indoor_explorers.evaluation.episodes.record.Record`."""

    covered: NDArray[np.int32]
    cells: NDArray[np.int16]
    actions: NDArray[np.uint8]
    seconds: NDArray[np.float32]
    sent: NDArray[np.int64]
    aloft: NDArray[np.int64]
    """(N,) steps that each UAV flew."""
    age: float | None
    """Age of information, None for a UAV alone."""


class Log:
    """Log a batch of B episodes of N UAVs from their start on; ``running`` (B,) says which still go on."""

    def __init__(self, world: World) -> None:
        batch, team = world.state.end.shape
        self._world = world
        self._team = team
        self._step = 0
        self._covered = np.zeros((batch, ROOM, 1 + team), np.int32)
        self._cells = np.zeros((batch, ROOM, team, 2), np.int16)
        self._actions = np.zeros((batch, ROOM, team), np.uint8)
        self._seconds = np.zeros((batch, ROOM), np.float32)
        self._sent = np.zeros((batch, ROOM), np.int64)
        self._aloft = np.zeros((batch, team), np.int64)
        self._ages = np.zeros(batch)
        self.running = np.ones(batch, np.bool_)
        self.steps = np.zeros(batch, np.int64)
        """(B,) steps flown by each episode."""
        self._note()

    def add(self, actions: NDArray[np.int64], seconds: NDArray[np.float64]) -> None:
        """Log the step just made: the (B, N) actions, and (B,) seconds that choosing them took."""
        if self._step + 1 == self._covered.shape[1]:
            self._grow()
        self._step += 1
        self.steps[self.running] = self._step
        self._actions[:, self._step - 1] = actions
        self._seconds[:, self._step] = self._seconds[:, self._step - 1] + seconds
        self._note()

    def _note(self) -> None:
        state, t = self._world.state, self._step
        self._covered[:, t, 0] = state.team_covered
        self._covered[:, t, 1:] = state.covered
        self._cells[:, t] = state.cell
        if self._team > 1:
            self._sent[:, t] = state.sent_bytes.sum(axis=1)
            self._ages += (t - np.maximum(state.last_received_step, 0)).sum(axis=(1, 2)) * self.running
        flying = self._world.flying
        self._aloft += flying
        self.running &= flying.any(axis=1)

    def _grow(self) -> None:
        for name in ("_covered", "_cells", "_actions", "_seconds", "_sent"):
            held = getattr(self, name)
            setattr(self, name, np.concatenate((held, np.zeros_like(held)), axis=1))

    def flown(self, episode: int) -> Flown:
        """Return what was logged of one episode up to its end."""
        b, last = episode, int(self.steps[episode])
        return Flown(
            covered=self._covered[b, : last + 1].copy(),
            cells=self._cells[b, : last + 1].copy(),
            actions=self._actions[b, :last].copy(),
            seconds=self._seconds[b, : last + 1].copy(),
            sent=self._sent[b, : last + 1].copy(),
            aloft=self._aloft[b].copy(),
            age=self._age(b, last),
        )

    def _age(self, episode: int, last: int) -> float | None:
        """Return the mean age in steps of what UAVs last heard of each other, over pairs and moments."""
        if self._team == 1:
            return None
        own = self._team * last * (last + 1) / 2  # a UAV never hears itself: its own entry grows by one a step
        pairs = self._team * (self._team - 1)
        return float((self._ages[episode] - own) / (pairs * (last + 1)))
