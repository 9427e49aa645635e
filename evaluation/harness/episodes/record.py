"""The record of one flown episode."""

from __future__ import annotations

import signal
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from enum import StrEnum
from typing import Self

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.evaluation.harness.episodes.steps import Steps, covered_columns
from indoor_explorers.evaluation.harness.experiment.experiment import Task

#: Quantities that coverage can be drawn against, with their units.
AXES = {"steps": "steps", "distance": "cells", "seconds": "s", "bytes": "bytes"}


#: Signals that may come from another program, such as the system when memory is short.
FROM_OUTSIDE = (signal.SIGKILL, signal.SIGTERM, signal.SIGHUP, signal.SIGINT)
#: How the reasons of failures begin whose process was killed or stopped, or used too much memory.
KILLED, STOPPED, TOO_MUCH_MEMORY = (
    *("the process of the policy was killed by signal", "the process of the policy was stopped"),
    "worker used more than",
)
#: How the reasons of failures begin that may be the machine's.
OF_THE_MACHINE = (*(f"{KILLED} {int(number)} " for number in FROM_OUTSIDE), STOPPED, TOO_MUCH_MEMORY)


class Outcome(StrEnum):
    """How an episode ended."""

    COMPLETE = "complete"
    """The scenario's goal coverage was reached."""
    BUDGET = "budget"
    """The step budget ran out first."""
    ENDED = "ended"
    """Every UAV crashed or was ended as stuck first."""
    FAILED = "failed"
    """The policy failed: it raised, returned no action, took too long or too much memory, or ended its process."""


def is_of_machine(reason: str) -> bool:
    """Return whether the machine may have caused a failure; exceptions and time-outs are the policy's."""
    return reason.startswith(OF_THE_MACHINE)


@dataclass(frozen=True, eq=False)
class FlownEpisode(Steps):
    """One episode of S steps by N UAVs without its map, which all episodes of a task share."""

    policy: str
    task: Task
    team: int
    budget: int
    """Steps."""
    reachable: int
    """The coverage denominator in cells."""
    outcome: Outcome
    reason: str
    """Why the policy failed, or what ended the UAVs; empty otherwise."""
    metrics: dict[str, float | None]
    """By the names of :data:`indoor_explorers.evaluation.harness.episodes.metrics.MEASURES`, and pilot statistics."""

    @property
    def bound(self) -> int:
        """Lower bound on the steps to 99 % on this task."""
        ratio, late = self.metrics["t99_to_bound"], self.metrics["t99"]
        return round((self.budget if late is None else late) / ratio) if ratio else 0

    @property
    def curve(self) -> NDArray[np.float64]:
        """(S + 1,) team coverage after each step."""
        return self.coverage()

    @property
    def seen(self) -> NDArray[np.int32]:
        """(S + 1,) counted cells that any UAV, or the home base, knows after each step."""
        _, base, seen = covered_columns(self.team)
        return self.covered[:, seen if self.covered.shape[1] > base else 0]

    def coverage(self, who: str = "team", steps: NDArray[np.integer] | None = None) -> NDArray[np.float64]:
        """Return (T,) coverage after each of T ``steps``, of all S + 1 by default.

        ``who`` is ``team`` (the union of the UAVs' maps, or the home base's map where only that counts), ``mean`` or
        ``worst`` (over the UAVs' own maps), or, with a base, ``base`` (its map) or ``seen`` (the union of all maps).
        """
        return self.coverage_of([who], steps).reshape(-1)

    def coverage_of(self, who: Sequence[str], steps: NDArray[np.integer] | None = None) -> NDArray[np.float64]:
        """Return (W, T) :meth:`coverage` of each of W names."""
        columns = (self.covered if steps is None else self.covered[steps]).T
        own, base, seen = covered_columns(self.team)
        found = np.empty((len(who), columns.shape[1]))
        for row, each in enumerate(who):
            if each == "mean":
                found[row] = columns[own].sum(axis=0)
                found[row] /= self.team
            elif each == "worst":
                found[row] = columns[own].min(axis=0)
            else:
                found[row] = columns[{"team": 0, "base": base, "seen": seen}[each]]
        found /= self.reachable
        return found

    def flew_like(self, other: FlownEpisode) -> bool:
        """Return whether both are the same step for step; decision times are ignored."""
        names = ("covered", "cells", "actions", "sent")
        same_end = (self.outcome, self.steps) == (other.outcome, other.steps)
        return same_end and all(np.array_equal(getattr(self, name), getattr(other, name)) for name in names)

    def with_metrics(self, metrics: dict[str, float | None]) -> Self:
        """Return the episode with other metrics."""
        return replace(self, metrics=metrics)

    def spent(self, axis: str) -> NDArray[np.float64]:
        """Return (S + 1,) the amount of one of :data:`AXES` spent up to each step; it never decreases."""
        if axis == "distance":
            return self.distance.astype(np.float64)
        spent = {"steps": np.arange(self.steps + 1), "seconds": self.seconds, "bytes": self.sent}
        return np.asarray(spent[axis], np.float64)


@dataclass(frozen=True, eq=False)
class Record(FlownEpisode):
    """An episode with its map.

    Map, seed and actions determine the whole episode, see
    :mod:`indoor_explorers.evaluation.harness.episodes.resimulate`; the other arrays are what figures are drawn from.
    """

    floorplan: Floorplan = field(repr=False)

    def without_map(self) -> FlownEpisode:
        """Return the episode without its map, for a receiver that knows the map."""
        return FlownEpisode(**{each.name: getattr(self, each.name) for each in fields(FlownEpisode)})


def mean_curve(records: Sequence[Record]) -> NDArray[np.float64]:
    """Return (T,) mean team coverage by step, each curve constant after its end; stored steps are read only once."""
    total = np.zeros(1 + max(record.steps for record in records))
    for record in records:
        curve, _ = record.curve, record.facts
        total[: len(curve)] += curve
        total[len(curve) :] += curve[-1]
    return total / len(records)
