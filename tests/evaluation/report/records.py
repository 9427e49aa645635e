"""Records with task_times made up by a test, of UAVs that hover in an empty room."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from indoor_explorers.env import Scenario, scenario
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.evaluation.harness.episodes.metrics import MEASURES
from indoor_explorers.evaluation.harness.episodes.record import Outcome, Record
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.results import Results

BUDGET, STEPS = 100, 4


def made_up(policy: str, task: Task, late: float | None, *, team: int = 1, **metrics: float | None) -> Record:
    """Return a record whose T90 and T99 are ``late``; other metrics are 1 where they are not given."""
    covered = np.linspace(1, 64, STEPS + 1).astype(np.int32)
    levels = dict.fromkeys(("t50", "t90", "t95", "t98", "t99"), late)
    return Record(
        policy=policy,
        task=task,
        floorplan=Floorplan(np.ones((8, 8), np.uint8), f"house-{task.map_index}"),
        team=team,
        budget=BUDGET,
        reachable=64,
        outcome=Outcome.BUDGET if late is None else Outcome.COMPLETE,
        reason="",
        metrics={**dict.fromkeys(MEASURES, 1.0), **levels, **metrics},
        covered=np.repeat(covered[:, None], 1 + team, axis=1),
        cells=np.full((STEPS + 1, team, 2), 3, np.int16),
        actions=np.full((STEPS, team), 4, np.uint8),
        seconds=np.linspace(0, 1, STEPS + 1).astype(np.float32),
        sent=np.zeros(STEPS + 1, np.int64),
    )


def room(name: str = "room", team: int = 1, **settings: Any) -> Scenario:
    """Return a scenario."""
    return scenario("thesis-obstacles").for_evaluation().with_settings({"name": name, "team": team, **settings})


def facts(*scenarios: Scenario) -> dict[str, dict[str, Any]]:
    """Return the settings of scenarios as a store holds them."""
    return {each.name: {"fingerprint": each.fingerprint, **each.model_dump(mode="json")} for each in scenarios}


def results_of(records: Sequence[Record], *scenarios: Scenario, privileged: Sequence[str] = ()) -> Results:
    """Put results together; policies in the order of their first record."""
    names = dict.fromkeys(record.policy for record in records)
    about = {name: {"privileged": name in privileged, "parameters": {}} for name in names}
    return Results(about, facts(*(scenarios or (room(),))), [], list(records))


def flown(times: Mapping[str, Sequence[float | None]], maps: Sequence[int] | None = None, **others: Any) -> Results:
    """Return results of one scenario from T99 by policy: one value a seed, on map 0 or on ``maps``."""
    records = [
        made_up(policy, Task("room", maps[seed] if maps else 0, seed), late)
        for policy, values in times.items()
        for seed, late in enumerate(values)
    ]
    return results_of(records, **others)
