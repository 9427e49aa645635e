"""Finds stored episodes whose facts are impossible or contradict each other.

Thousands of episodes are checked at once, as a report reads all of them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import TURN
from indoor_explorers.evaluation.harness.episodes.metrics import LEVELS
from indoor_explorers.evaluation.harness.episodes.record import Outcome, Record
from indoor_explorers.evaluation.harness.experiment.experiment import Task

#: Differences of metrics that are rounding errors.
TOLERANCE = 1e-6


def contradictions(records: Sequence[Record]) -> dict[tuple[str, Task], str]:
    """Return what is wrong with records, by their policies and tasks."""
    found = {(record.policy, record.task): why for record in records if (why := _out_of_range(record))}
    sound = [record for record in records if (record.policy, record.task) not in found]
    for kind in {_columns(record) for record in sound}:
        alike = [record for record in sound if _columns(record) == kind]
        found |= {(alike[n].policy, alike[n].task): why for n, why in _contradicting(alike).items()}
    return found


def _columns(record: Record) -> tuple[int, int]:
    """Return what the arrays of records must have in common to be checked together: UAVs and columns of coverage."""
    return record.team, record.covered.shape[1]


def _out_of_range(record: Record) -> str:
    if min(record.team, record.budget, record.reachable) < 1 or not 0 <= record.steps <= record.budget:
        return "team, budget, steps or reachable cells are out of range"
    if record.outcome is Outcome.BUDGET and record.steps != record.budget:
        return "it ended before its budget"
    if not all(value is None or type(value) in (float, int) for value in record.metrics.values()):
        return "its metrics are not numbers"
    return ""


def _contradicting(records: Sequence[Record]) -> dict[int, str]:
    """Check episodes of equally many UAVs."""
    steps = np.array([record.steps for record in records])
    starts = np.concatenate(([0], np.cumsum(steps + 1)[:-1]))
    cells = np.concatenate([record.cells for record in records])
    farthest = np.maximum.reduceat(cells.astype(np.uint16).max(axis=1), starts)  # negative ones become very large
    off_map = (farthest >= [record.floorplan.shape for record in records]).any(axis=1)
    found = {int(n): "its UAVs left the map" for n in np.flatnonzero(off_map)}
    if np.concatenate([record.actions for record in records]).max(initial=0) > TURN:
        actions = (record.actions.max(initial=0) for record in records)
        found |= {n: "it has an unknown action" for n, action in enumerate(actions) if action > TURN}
    derived = _team_metrics(records, starts, steps) | _travel(records, starts, cells)
    for metric, values in derived.items():
        told = np.array([record.metrics.get(metric) for record in records], np.float64)  # None becomes NaN
        for n in np.flatnonzero(~np.isclose(told, values, TOLERANCE, TOLERANCE, equal_nan=True)):
            found[int(n)] = f"{metric} is {told[n]:g}, but its stored steps give {values[n]:g}"
    return found


def _team_metrics(
    records: Sequence[Record], starts: NDArray[np.int64], steps: NDArray[np.int64]
) -> dict[str, NDArray[np.float64]]:
    """Return what :func:`~indoor_explorers.evaluation.harness.episodes.metrics.team_metrics` says of each record."""
    covered = np.concatenate([record.covered for record in records])
    own, budget = covered[:, 1 : 1 + records[0].team], np.array([[record.budget] for record in records])
    reachable = np.array([record.reachable for record in records])
    curves = np.stack([covered[:, 0], own.min(axis=1), own.mean(axis=1)], axis=1)
    curves /= np.repeat(reachable, steps + 1)[:, None]
    last = curves[starts + steps]
    flown = np.add.reduceat(curves, starts) - (curves[starts] + last) / 2
    areas = (flown + last * (budget - steps[:, None])) / budget
    step = np.arange(len(curves)) - np.repeat(starts, steps + 1)
    firsts = {
        name: np.minimum.reduceat(np.where(curves[:, 0] >= q - 1e-12, step, len(curves)), starts)
        for name, q in LEVELS.items()
    }
    times = {name: np.where(first > steps, np.nan, first) for name, first in firsts.items()}
    return dict(zip(("auc", "auc_worst", "auc_mean"), areas.T, strict=True)) | times


def _travel(
    records: Sequence[Record], starts: NDArray[np.int64], cells: NDArray[np.int16]
) -> dict[str, NDArray[np.float64]]:
    """Return the cells flown and the bytes sent."""
    moved = np.abs(np.diff(cells, axis=0, prepend=cells[:1])).sum(axis=(1, 2), dtype=np.float64)
    moved[starts] = 0.0
    sent = np.array([record.sent[-1] for record in records], np.float64)
    return {"path_length": np.add.reduceat(moved, starts), "messages_bytes": sent}
