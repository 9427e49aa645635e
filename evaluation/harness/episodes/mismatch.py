"""Finds values of a record that do not follow from its map, seed and actions."""

from __future__ import annotations

from typing import Any

import numpy as np

from indoor_explorers.env import Scenario
from indoor_explorers.evaluation.harness.episodes.metrics import OF_THE_MACHINE
from indoor_explorers.evaluation.harness.episodes.record import Outcome, Record
from indoor_explorers.evaluation.harness.episodes.running import RunningEpisode, simulated_record

#: Metrics that do not follow from map, seed and actions: times, and what messages of pilots add to bytes.
NOT_SIMULATED = (*OF_THE_MACHINE, "messages_bytes")


def mismatch(record: Record, scenario: Scenario) -> str:
    """Return in what an episode differs from its simulation by map, seed and actions; empty if in nothing."""
    failure = record.reason if record.outcome is Outcome.FAILED else ""
    flight = RunningEpisode(0, record.task, record.floorplan, record.bound, failure=failure)
    again = simulated_record(flight, record.policy, scenario, record)
    for name in ("steps", "outcome", "reachable", "budget"):
        stored, simulated = getattr(record, name), getattr(again, name)
        if stored != simulated:
            return f"{name} {stored}, simulated {simulated}"
    for name in ("cells", "covered"):
        if not np.array_equal(getattr(record, name), getattr(again, name)):
            return f"{name} differ from those simulated from its actions"
    for name, simulated in again.metrics.items():
        if name not in NOT_SIMULATED and not _equal(record.metrics.get(name), simulated):
            return f"{name} {record.metrics.get(name)}, simulated {simulated}"
    return ""


def _equal(stored: Any, simulated: Any) -> bool:
    if stored is None or simulated is None:
        return stored is simulated
    return bool(np.isclose(stored, simulated, rtol=1e-9, atol=0.0))
