"""Which episodes the page replays, and their data, kept within a number of bytes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from indoor_explorers.env.grid import OCCUPIED
from indoor_explorers.evaluation.experiment import Task
from indoor_explorers.evaluation.record import Outcome, Record
from indoor_explorers.evaluation.report.comparison import Comparison
from indoor_explorers.evaluation.report.flight import known_from, pack_flight
from indoor_explorers.evaluation.report.numbers import EN_DASH
from indoor_explorers.evaluation.report.packing import bits, text
from indoor_explorers.evaluation.report.palette import Style

#: The most frames of a replay; longer episodes skip steps.
FRAMES = (1200, 300, 75)


def replay_data(comparison: Comparison, looks: Mapping[str, Style], limit: int) -> dict[str, Any] | None:
    """Return the replays of a scenario as JSON data of about ``limit`` bytes at most, None when nothing fits."""
    reach = float(comparison.results.scenarios[comparison.scenario]["lidar"]["range"])
    episodes, left = [], limit
    for label, task in chosen_tasks(comparison):
        episode, size = _episode(comparison, task, reach, left)
        if episode is not None:
            episodes.append({"label": label, **episode})
            left -= size
    if not episodes:
        return None
    policies = [{"name": name, **looks[name]._asdict()} for name in comparison.groups]
    return {"range": reach, "policies": policies, "episodes": episodes}


def chosen_tasks(comparison: Comparison) -> list[tuple[str, Task]]:
    """Return the median, fastest and slowest task by mean T99 over the policies, and one with a failure."""
    flown: dict[Task, list[tuple[float, float]]] = {}
    for records in comparison.groups.values():
        for record in records:
            flown.setdefault(record.task, []).append(_lateness(record))
    most = max((len(entries) for entries in flown.values()), default=0)
    common = [task for task, entries in flown.items() if len(entries) == most]
    order = sorted(common, key=lambda task: (*np.mean(flown[task], axis=0).tolist(), task))
    if not order:
        return []
    picks = [("median", order[(len(order) - 1) // 2]), ("fastest", order[0]), ("slowest", order[-1])]
    failed = sorted(r.task for rs in comparison.groups.values() for r in rs if r.outcome is Outcome.FAILED)
    picks += [("with a failure", task) for task in failed[:1]]
    unique = {task: label for label, task in reversed(picks)}
    return [(label, task) for label, task in picks if unique[task] == label]


def _lateness(record: Record) -> tuple[float, float]:
    late = record.metrics.get("t99")
    return (float(record.budget) if late is None else late), -(record.metrics.get("auc") or 0.0)


def _episode(comparison: Comparison, task: Task, reach: float, limit: int) -> tuple[dict[str, Any] | None, int]:
    """Return one task's replay with as many policies as fit, best first, and its size in bytes."""
    flown = {r.policy: r for records in comparison.groups.values() for r in records if r.task == task}
    ranked = [flown[name] for name in comparison.ranking if name in flown]
    plan = ranked[0].floorplan
    walls = bits(plan.truth == OCCUPIED)
    known = {record.policy: known_from(record, reach) for record in ranked}
    for frames in FRAMES:
        stride = 1 + max(record.steps for record in ranked) // frames
        flights, size = [], len(walls)
        for record in ranked:
            stream = text(pack_flight(record, known[record.policy], stride))
            if size + len(stream) <= limit:
                flights.append(_flight(comparison, record, stream))
                size += len(stream)
        if flights:
            height, width = plan.shape
            about = {"seed": task.seed, "map": plan.name, "height": height, "width": width, "walls": walls}
            return {**about, "stride": stride, "total": ranked[0].reachable, "flights": flights}, size
    return None, 0


def _flight(comparison: Comparison, record: Record, stream: str) -> dict[str, Any]:
    return {
        "policy": list(comparison.groups).index(record.policy),
        "team": record.team,
        "steps": record.steps,
        "end": ending(record),
        "stream": stream,
    }


def ending(record: Record) -> str:
    """Say in a few words how an episode ended."""
    words = {
        Outcome.COMPLETE: "goal reached",
        Outcome.BUDGET: "budget spent",
        Outcome.ENDED: "all UAVs ended",
        Outcome.FAILED: "policy failed",
    }[record.outcome]
    return f"{words} {EN_DASH} {record.reason}" if record.reason else words
