"""Simulate a recorded episode again from its map, seed and actions: step by step, or to find what does not follow."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from indoor_explorers.env import Scenario, World
from indoor_explorers.env.scenarios.validation import validated
from indoor_explorers.evaluation.episodes.metrics import OF_THE_MACHINE
from indoor_explorers.evaluation.episodes.record import Outcome, Record
from indoor_explorers.evaluation.episodes.running import RunningEpisode, simulated_record

#: Metrics that do not follow from map, seed and actions: times, and what messages of pilots add to bytes.
NOT_SIMULATED = (*OF_THE_MACHINE, "messages_bytes")


def recorded_scenario(settings: Mapping[str, Any]) -> Scenario:
    """Return a stored scenario; its map source is left out, since records bring their own maps."""
    kept = {key: value for key, value in settings.items() if key not in ("fingerprint", "map")}
    return validated(Scenario, kept, f"stored scenario {kept.get('name')!r}")


def resimulate(record: Record, scenario: Scenario) -> Iterator[World]:
    """Yield a world with the recorded episode in place 0, at its start and after each of its S steps.

    Positions, beliefs, radio contacts and coverage are those of the recorded episode; messages of pilots are not
    stored. Every step yields the same world object: read it before asking for the next.
    """
    world = World(scenario)
    world.begin(0, record.task.seed, floorplan=record.floorplan)
    yield world
    for actions in record.actions:
        world.step(actions[None])
        yield world


def ended_as_recorded(record: Record, world: World) -> bool:
    """Tell whether the simulated episode in place 0 ended as recorded; in another version of the world it may not."""
    state = world.state
    return np.array_equal(state.cell[0], record.cells[-1]) and bool(state.team_covered[0] == record.seen[-1])


def mismatch(record: Record, scenario: Scenario) -> str:
    """Return in what an episode differs from its simulation by map, seed and actions; empty if in nothing."""
    flight = RunningEpisode(0, record.task, record.floorplan, record.bound, failure=_failure(record))
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


def _failure(record: Record) -> str:
    return record.reason if record.outcome is Outcome.FAILED else ""


def _equal(stored: Any, simulated: Any) -> bool:
    if stored is None or simulated is None:
        return stored is simulated
    return bool(np.isclose(stored, simulated, rtol=1e-9, atol=0.0))
