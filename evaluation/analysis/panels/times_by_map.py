"""The table of times by map, or by seed where a scenario has one map or generates them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.panels.replay_links import ReplayCell, replay_link
from indoor_explorers.evaluation.analysis.task_times import TaskTimes
from indoor_explorers.evaluation.drawing.formatting import counted, fixed, interval, seed_base
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.statistics import bootstrap_mean

#: Limits of maps and of seeds that are shown.
MAPS, SEEDS = 60, 40
#: Upper limits of the ratio to the best policy for each shade.
SHADES = (1.0, 1.1, 1.25, 1.5, 2.0)


@dataclass(frozen=True)
class TimesTable:
    """A table of units, which are maps or seeds, by policies."""

    unit: str
    """``map`` or ``seed``."""
    base: int
    """What the rows' seeds are counted from; 0 for whole seeds and for maps."""
    policies: list[str]
    rows: list[tuple[str, list[ReplayCell]]]
    """By unit; a cell a policy, shaded from 0 for the best to 5 for more than twice its steps or never reached."""
    won: list[tuple[int, int]]
    """By policy: how many units it won alone, and how many together with others."""
    units: int
    """Number of units; ``rows`` has the first of them."""
    tasks: int


def times_table(comparison: Comparison, task_times: TaskTimes) -> TimesTable | None:
    """Return the table over the tasks that all ranked policies flew; None without any or with a single policy."""
    common = task_times.common()
    if not common.tasks or len(common.policies) < 2:
        return None
    maps = common.by_map()
    return _by_map(comparison, common, maps) if len(maps) > 1 else _by_seed(common)


def _by_map(comparison: Comparison, common: TaskTimes, maps: dict[int, TaskTimes]) -> TimesTable:
    names = {r.task.map_index: r.floorplan.name for r in comparison.records}
    means = np.stack([here.times.mean(axis=0) for here in maps.values()])
    rows = [
        (names[index], [_on_map(here, column, names[index]) for column in range(len(common.policies))])
        for index, here in list(maps.items())[:MAPS]
    ]
    return TimesTable("map", 0, common.policies, rows, _won(means), len(maps), len(common.tasks))


def _by_seed(common: TaskTimes) -> TimesTable:
    base = seed_base([task.seed for task in common.tasks])
    rows = [
        (str(task.seed - base), [_on_task(common, row, column) for column in range(len(common.policies))])
        for row, task in enumerate(common.tasks[:SEEDS])
    ]
    return TimesTable("seed", base, common.policies, rows, _won(common.times), len(common.tasks), len(common.tasks))


def _won(times: NDArray[np.float64]) -> list[tuple[int, int]]:
    """Return for each column of (U, P) how many units it has the lowest value of alone, and with others."""
    first = np.isclose(times, times.min(axis=1, keepdims=True), rtol=0, atol=1e-9)
    alone = first & (first.sum(axis=1, keepdims=True) == 1)
    everyone = first.all(axis=1, keepdims=True)
    return list(zip(alone.sum(axis=0).tolist(), (first & ~alone & ~everyone).sum(axis=0).tolist(), strict=True))


def _on_map(here: TaskTimes, column: int, name: str) -> ReplayCell:
    """Return the cell of a policy on one map; it links to the episode nearest to the mean."""
    estimate = bootstrap_mean(here.times[:, column])
    means = here.times.mean(axis=0)
    ratio, reached = _ratio(means, column), int(here.reached[:, column].sum())
    typical = int(np.argmin(np.abs(here.times[:, column] - estimate.mean)))
    detail = f"{interval(estimate, 1)} {reached}/{len(here.tasks)}".strip()
    mean = f"mean {here.level.title} {fixed(estimate.mean, 1)} {interval(estimate, 1)} steps"
    there = f"{here.level.percent} reached in {reached} of {counted(len(here.tasks), 'episode')}"
    title = f"{here.policies[column]} on {name}: {mean}, {_times(ratio)}; {there}"
    return _place(fixed(estimate.mean, 1), detail, ratio, means, title, here, column, here.tasks[typical])


def _on_task(common: TaskTimes, row: int, column: int) -> ReplayCell:
    times, task = common.times[row], common.tasks[row]
    ratio = _ratio(times, column)
    there = bool(common.reached[row, column])
    steps = f"{fixed(times[column], 0)} steps" if there else f"{common.level.percent} never reached"
    title = f"{common.policies[column]}, seed {task.seed}: {steps}, {_times(ratio)}"
    here = common.among([row])
    return _place(fixed(times[column], 0) if there else "never", "", ratio, times, title, here, column, task)


def _place(
    text: str,
    detail: str,
    ratio: float,
    times: NDArray[np.float64],
    title: str,
    here: TaskTimes,
    column: int,
    task: Task,
) -> ReplayCell:
    """Return the cell of a policy; ``times`` (P,) are the steps of all policies on this map or task."""
    reached = bool(here.reached[:, column].any())
    level = len(SHADES) if not reached else int(np.searchsorted(SHADES, ratio - 1e-9))
    decided = bool((times > times.min() + 1e-9).any())
    return ReplayCell(
        text,
        detail=detail,
        best=decided and ratio <= 1 + 1e-9,
        shade=level,
        title=title,
        replay=replay_link(here.policies[column], task),
    )


def _ratio(times: NDArray[np.float64], column: int) -> float:
    """Return a policy's steps as a multiple of the fewest of (P,) steps; a threshold reached at once counts as 1."""
    counted_steps = np.maximum(times, 1.0)
    return float(counted_steps[column] / counted_steps.min())


def _times(ratio: float) -> str:
    return "the best" if ratio <= 1 + 1e-9 else f"{ratio:.2f} times the best"
