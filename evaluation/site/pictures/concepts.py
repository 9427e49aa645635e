"""The pictures of the page on concepts, drawn from the world itself."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy import ndimage

from indoor_explorers.env import FREE, OCCUPIED, UNKNOWN, World, make_policy, scenario
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.sensing.lidar import scan
from indoor_explorers.env.simulation.radio import in_reach
from indoor_explorers.env.simulation.state import rules_of
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.site.pictures.drawing import LOST, MARKED, UAV, cells, fly_steps, svg
from indoor_explorers.evaluation.statistics import bootstrap_mean


def concept_pictures() -> dict[str, bytes]:
    """Return the SVG files of the page by name."""
    drawn = {"lidar": _lidar, "radio": _radio, "belief": _belief, "coverage": _coverage, "pairs": _pairs}
    return {f"concept-{name}.svg": svg(draw) for name, draw in drawn.items()}


def _lidar(figure: Figure) -> None:
    truth = np.full((15, 15), FREE, np.uint8)
    truth[4, 3:9] = truth[9:12, 4] = truth[10, 9:13] = truth[6:8, 11] = truth[2, 12] = OCCUPIED
    figure.set_size_inches(5.2, 2.8)
    for axes, model, title in zip(
        figure.subplots(1, 2), ("exact", "marsexplorer"), ("exact", "rays of MarsExplorer"), strict=True
    ):
        seen = scan(truth, (7, 7), 6.0, model) != UNKNOWN
        cells(axes, np.where(seen & (truth == FREE), MARKED, truth), title, [(7, 7)])


def _radio(figure: Figure) -> None:
    truth = np.full((21, 21), FREE, np.uint8)
    truth[7, :15] = truth[13, 6:] = truth[8:13, 14] = OCCUPIED
    truth[7, 4] = truth[10, 14] = FREE
    here = (10, 9)
    figure.set_size_inches(7.0, 2.1)
    for axes, model in zip(figure.subplots(1, 4), ("square", "disc", "line-of-sight", "path-loss"), strict=True):
        radio = {"radio.model": model, "radio.range": 8.0}
        rules = rules_of(scenario("thesis-team-2").with_settings(radio))
        linked = np.array([[_in_contact(rules, truth, here, (r, c)) for c in range(21)] for r in range(21)])
        cells(axes, np.where(linked & (truth == FREE), MARKED, truth), model, [here])


def _in_contact(rules: Any, truth: NDArray[np.uint8], one: tuple[int, int], other: tuple[int, int]) -> bool:
    rule: Any = in_reach
    return one == other or bool(rule.py_func(rules, truth, *one, *other))


def _belief(figure: Figure) -> None:
    world = World(scenario("small-offices").with_settings({"team": 2, "radio.model": "none", "spawn": "random"}))
    world.reset([4])
    fly_steps(world, make_policy("frontier-nearest"), 71)
    state = world.state
    figure.set_size_inches(7.0, 2.0)
    uavs = state.cell[0].tolist()
    shown = (state.truth[0], state.belief[0, 0], state.belief[0, 1], state.union[0])
    titles = ("true map", "UAV 0 knows", "UAV 1 knows", "the team knows")
    for axes, codes, title, who in zip(
        figure.subplots(1, 4), shown, titles, (uavs, uavs[:1], uavs[1:], uavs), strict=True
    ):
        cells(axes, codes, title, who)


def _coverage(figure: Figure) -> None:
    free = np.ones((14, 20), np.bool_)
    free[[0, -1], :] = free[:, [0, -1]] = False
    free[4:10, 12] = free[4, 12:17] = free[9, 12:17] = free[4:10, 16] = free[7:13, 5:8] = False
    plan = Floorplan.from_free(free, "a closed room")
    figure.set_size_inches(5.6, 2.1)
    for axes, counted in zip(figure.subplots(1, 2), ("reachable", "map"), strict=True):
        world = World(scenario("thesis-open").with_settings({"denominator": counted}))
        world.begin(0, 1, floorplan=plan, spawns=[(2, 3)])
        counts, truth = world.state.counts[0], world.state.truth[0]
        seeable = np.zeros(truth.shape, np.bool_)
        for row, col in np.argwhere(free & ~_closed(free)).tolist():
            seeable |= scan(truth, (row, col), 3.0) != UNKNOWN
        codes = np.where(counts, np.where(seeable, MARKED, LOST), truth)
        cells(axes, codes, f'denominator = "{counted}"', [(2, 3)])


def _closed(free: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the free cells that cannot be reached from (2, 3)."""
    parts, _ = ndimage.label(free)
    return np.asarray(free & (parts != parts[2, 3]))


def _pairs(figure: Figure) -> None:
    task = scenario("small-floors").for_evaluation()
    tasks = [Task(task.name, 0, seed) for seed in range(24)]
    times = {}
    for name in ("frontier-nearest", "frontier"):
        records = fly(make_policy(name), name, task, tasks, bounds=dict.fromkeys(tasks, 1))
        times[name] = np.array([record.metrics["t99"] for record in records], np.float64)
    one, other = times.values()
    figure.set_size_inches(6.8, 2.6)
    left, right = figure.subplots(1, 2, width_ratios=(1, 1.3))
    left.plot(one, other, **UAV | {"markersize": 3.5})
    ends = [min(one.min(), other.min()) - 2, max(one.max(), other.max()) + 2]
    left.plot(ends, ends, color="#888888", linewidth=0.8)
    left.set(
        xlabel="T99 of frontier-nearest [steps]", ylabel="T99 of frontier [steps]", title="24 tasks", aspect="equal"
    )
    paired = bootstrap_mean(other - one)
    spread = 1.96 * np.sqrt(one.var(ddof=1) / len(one) + other.var(ddof=1) / len(other))
    right.errorbar(
        [paired.mean] * 2,
        [1, 0],
        xerr=[[paired.mean - (paired.low or 0), spread], [(paired.high or 0) - paired.mean, spread]],
        fmt="o",
        color="#2f6f9f",
        capsize=3,
    )
    right.axvline(0, color="#888888", linewidth=0.8)
    right.set(yticks=[1, 0], yticklabels=["paired", "as if other tasks"], ylim=(-0.7, 1.7))
    right.set(xlabel="T99 of frontier minus frontier-nearest [steps]", title="95 % intervals of the difference")
