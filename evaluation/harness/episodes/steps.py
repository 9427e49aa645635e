"""The stored steps of an episode."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.compiled import leaf


def covered_columns(team: int) -> tuple[slice, int, int]:
    """Return the columns of :attr:`Steps.covered` for the UAVs' own maps, the home base, and all of these together.

    Column 0 is the coverage that counts; the last two exist only in episodes with a home base.
    """
    return slice(1, 1 + team), 1 + team, 2 + team


def step_type(team: int, base: bool = False) -> np.dtype[Any]:
    """Return the type of a log row: the facts after a step of N UAVs, with a home base or not; row 0 is the start."""
    return np.dtype(
        [
            ("covered", np.int32, (1 + team + (2 if base else 0),)),
            ("cells", np.int16, (team, 2)),
            ("actions", np.uint8, (team,)),
            ("seconds", np.float32),
            ("sent", np.int64),
        ]
    )


class StepFacts(NamedTuple):
    """The facts about the steps of an episode that reports use for every episode."""

    flight: bytes
    """Digest of actions and covered cells."""
    track: bytes
    """Digest of where the UAVs were."""
    start: bytes
    """Where they were at first."""
    first_seconds: float
    """The first seconds above 0; infinite where there are none."""
    distance: float
    """Cells flown in the end."""
    seconds: float
    """Seconds of decisions in the end."""
    bytes: float
    """Bytes sent in the end."""


@dataclass(frozen=True, eq=False)
class Steps:
    """The S steps of an episode by N UAVs."""

    covered: NDArray[np.int32] = field(repr=False)
    """(S + 1, 1 + N) cells covered after each step: by the team together, then by each UAV's own map.

    With a home base (S + 1, 1 + N + 2), see :func:`covered_columns`."""
    cells: NDArray[np.int16] = field(repr=False)
    """(S + 1, N, 2) row and column of each UAV after each step."""
    actions: NDArray[np.uint8] = field(repr=False)
    """(S, N) what each UAV chose at each step; ``stay`` once it has ended."""
    seconds: NDArray[np.float32] = field(repr=False)
    """(S + 1,) seconds that the team's decisions took up to each step, all UAVs together."""
    sent: NDArray[np.int64] = field(repr=False)
    """(S + 1,) bytes that the team sent by radio up to each step."""

    @classmethod
    def of(cls, rows: NDArray[np.void]) -> Steps:
        """Copy the steps from S + 1 rows of :func:`step_type`; no rows give no steps."""
        arrays = {name: rows[name].copy() for name in rows.dtype.names or ()}
        return cls(**arrays | {"actions": arrays["actions"][1:]})

    @property
    def steps(self) -> int:
        """How many steps were flown."""
        return len(self.actions)

    @property
    def size(self) -> int:
        """Bytes of all arrays and of :attr:`distance`."""
        arrays = (self.covered, self.cells, self.actions, self.seconds, self.sent)
        return self.sent.nbytes + sum(array.nbytes for array in arrays)

    @cached_property
    def distance(self) -> NDArray[np.int64]:
        """(S + 1,) cells flown by all UAVs together up to each step."""
        flown = np.zeros(len(self.cells), np.int64)
        _fly(self.cells, flown)
        return flown

    @cached_property
    def facts(self) -> StepFacts:
        """The facts that reports use for every episode, in few bytes."""
        first = float(self.seconds[np.argmax(self.seconds > 0)]) if self.seconds[-1] > 0 else np.inf
        ends = float(self.distance[-1]), float(self.seconds[-1]), float(self.sent[-1])
        flight, track = _digest(self.actions, self.covered), _digest(self.cells)
        return StepFacts(flight, track, self.cells[0].tobytes(), first, *ends)


@leaf()
def _fly(cells: NDArray[np.int16], flown: NDArray[np.int64]) -> None:
    """Add to (S + 1,) ``flown``, which is 0 at first, the cells flown up to each step: one a move, up and down too."""
    for step in range(1, len(cells)):
        flown[step] = flown[step - 1]
        for uav in range(cells.shape[1]):
            before, now = cells[step - 1, uav], cells[step, uav]
            flown[step] += int(before[0] != now[0] or before[1] != now[1])


def _digest(*arrays: NDArray[Any]) -> bytes:
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(np.ascontiguousarray(array).data)
    return digest.digest()[:16]
