"""Which episodes the page replays, and their data, kept within a number of bytes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from math import inf
from typing import Any, NamedTuple

import numpy as np

from indoor_explorers.env.grid.cells import OCCUPIED
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.failures import ending
from indoor_explorers.evaluation.analysis.outliers import far_behind
from indoor_explorers.evaluation.drawing.palette import DASHES, Styles
from indoor_explorers.evaluation.harness.episodes.record import Outcome
from indoor_explorers.evaluation.harness.episodes.stored_names import MODELS, refusal
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.report.packing import bits, text
from indoor_explorers.evaluation.report.replay.explanations import Explaining, size_of
from indoor_explorers.evaluation.report.replay.packed_episode import ReplayEpisode, pack_episode, resimulated


class Detail(NamedTuple):
    """How finely an episode is replayed."""

    frames: int
    """The most frames; longer episodes skip steps."""
    own: bool
    """Whether each UAV's own map is there, not the team's alone."""


#: From the finest to the coarsest.
DETAILS = (Detail(6000, True), Detail(1200, True), Detail(1200, False), Detail(300, False), Detail(75, False))


class Pick(NamedTuple):
    """A task to replay, and why it was chosen."""

    label: str
    task: Task


def replay_data(
    comparison: Comparison,
    styles: Styles,
    limit: int,
    count: int | None = None,
    explaining: Explaining | None = None,
) -> dict[str, Any] | None:
    """Return the replays of a scenario as JSON data, None when there are none.

    Args:
        comparison: the scenario's results.
        styles: the look of each policy.
        limit: approximate limit in bytes; the most interesting episodes come first.
        count: replay this number of episodes instead, whatever their size.
        explaining: explains them, see :mod:`~.explanations`; none by default.

    A scenario with a model from outside this package that the user did not name has none.
    """
    settings = comparison.results.scenarios[comparison.scenario]
    if refusal(settings, comparison.results.plugins, MODELS):
        return None
    explaining = explaining or Explaining(comparison.results, 0.0)
    if count is None:
        episodes = list(_fitting(comparison, limit, explaining))
    else:
        picks = chosen(comparison, everything=True)[:count]
        found = (_episode(comparison, pick, inf, inf, explaining) for pick in picks)
        episodes = [episode for episode in found if episode is not None]
    if not episodes:
        return None
    far, scenario = far_behind(comparison), comparison.results.scenario(comparison.scenario)
    return {
        "range": float(settings["lidar"]["range"]),
        "policies": [
            {
                "name": name,
                "colour": styles[name].colour,
                "dashes": DASHES[styles[name].dash],
                "far": name in far,
            }
            for name in comparison.groups
        ],
        "tasks": len(comparison.results.tasks(comparison.scenario)),
        "counts": "base" if scenario.base.must_return else "team",
        "fail": scenario.failures.hazard > 0.0 or bool(scenario.failures.stops),
        "episodes": episodes,
    }


def _fitting(comparison: Comparison, limit: int, explaining: Explaining) -> Iterator[dict[str, Any]]:
    """Yield episodes as long as they fit; the notable ones share the bytes evenly."""
    notable = len(notable_tasks(comparison))
    left = limit
    for place, pick in enumerate(chosen(comparison)):
        share = left // max(1, notable - place)
        episode = _episode(comparison, pick, share, left, explaining)
        if episode is None:
            return
        yield episode
        left -= sum(len(flight["stream"]) + size_of(flight["why"]) for flight in episode["flights"])


def chosen(comparison: Comparison, *, everything: bool = False) -> list[Pick]:
    """Return the notable tasks, then a task of each other map, then all others with ``everything``."""
    order = _by_lateness(comparison)
    picks = {pick.task: pick for pick in notable_tasks(comparison, order)}
    maps = {task.map_index for task in order} - {task.map_index for task in picks}
    others: defaultdict[int, list[Task]] = defaultdict(list)
    for task in order:
        others[task.map_index].append(task)
    medians = [others[index][(len(others[index]) - 1) // 2] for index in sorted(maps)]
    picks |= {task: Pick("median of its map", task) for task in medians}
    if everything:
        rest = sorted(comparison.results.tasks(comparison.scenario) - picks.keys())
        picks |= {task: Pick("episode", task) for task in rest}
    return list(picks.values())


def notable_tasks(comparison: Comparison, order: Sequence[Task] | None = None) -> list[Pick]:
    """Return the median, fastest and slowest task by mean time over the policies, and one with a failure."""
    order = _by_lateness(comparison) if order is None else order
    if not order:
        return []
    picks = [("median", order[(len(order) - 1) // 2]), ("fastest", order[0]), ("slowest", order[-1])]
    failed = sorted(r.task for r in comparison.records if r.outcome is Outcome.FAILED)
    picks += [("with a failure", task) for task in failed[:1]]
    unique = {task: label for label, task in reversed(picks)}
    return [Pick(label, task) for label, task in picks if unique[task] == label]


def _by_lateness(comparison: Comparison) -> list[Task]:
    """Return the tasks flown by most policies, by mean time to the threshold over the policies, then falling AUC."""
    flown: defaultdict[Task, list[list[float]]] = defaultdict(list)
    for policy, records in comparison.groups.items():
        late, area = (
            comparison.results.values(comparison.scenario, policy, metric) for metric in (comparison.level.key, "auc")
        )
        for record, *entry in zip(records, late.tolist(), (-np.nan_to_num(area)).tolist(), strict=True):
            flown[record.task].append(entry)
    most = max((len(entries) for entries in flown.values()), default=0)
    common = [task for task, entries in flown.items() if len(entries) == most]
    return sorted(common, key=lambda task: (*(sum(parts) / most for parts in zip(*flown[task], strict=True)), task))


def _episode(
    comparison: Comparison, pick: Pick, share: float, left: float, explaining: Explaining
) -> dict[str, Any] | None:
    """Return one task's replay in the finest detail that its share of bytes allows.

    If even the coarsest is too large, it may use all bytes left, without the lowest ranked policies if necessary.
    """
    flown = {r.policy: r for r in comparison.records if r.task == pick.task}
    scenario = comparison.results.scenario(comparison.scenario)
    again = [resimulated(flown[name], scenario) for name in comparison.ranking if name in flown]
    flights = [flight for flight in again if flight.faithful]
    if not flights:
        return None
    plan, steps = flights[0].record.floorplan, max(flight.record.steps for flight in flights)
    base, prior = flights[0].base, flights[0].prior
    walls, counted = bits(plan.truth == OCCUPIED), bits(flights[0].counted)
    foreseen = None if prior is None else bits(prior == OCCUPIED)
    for detail in [detail for detail in DETAILS if not (detail.own and scenario.uncertain)]:
        stride = 1 + steps // detail.frames
        streams = [text(pack_episode(flight, stride, own=detail.own)) for flight in flights]
        sizes = len(walls) + len(counted) + len(foreseen or "") + np.cumsum([len(stream) for stream in streams])
        if sizes[-1] <= share:
            break
    fits = int((sizes <= left).sum())
    if not fits:
        return None
    return {
        "label": pick.label,
        "map": plan.name,
        "task": [pick.task.map_index, pick.task.seed],
        "height": plan.shape[0],
        "width": plan.shape[1],
        "walls": walls,
        "counted": counted,
        "prior": foreseen,
        "base": base,
        "total": flights[0].record.reachable,
        "stride": stride,
        "own": detail.own,
        "revised": scenario.uncertain,
        "flights": [
            _flight(comparison, flight, stream) | {"why": explaining.told(flight.record)}
            for flight, stream in zip(flights[:fits], streams[:fits], strict=True)
        ],
    } | ({"levels": plan.level_count} if plan.level_count > 1 else {})


def _flight(comparison: Comparison, flight: ReplayEpisode, stream: str) -> dict[str, Any]:
    record = flight.record
    names, same = list(comparison.groups), comparison.same_as.get(record.policy)
    return {
        "policy": names.index(record.policy),
        "same": names.index(same) if same else None,
        "team": record.team,
        "steps": record.steps,
        "end": ending(record),
        "stops": [(uav, step) for uav, step in enumerate(flight.stopped.tolist()) if step <= record.steps],
        "stream": stream,
    }
