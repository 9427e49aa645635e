"""The pictures of the page on planners: real decisions on generated floors, read from the pilots that make them.

Evaluation imports no planner, so pilots come from the registry, and what they decide from is asked of them by name.
"""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from string import ascii_uppercase
from typing import Any

import numpy as np
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from indoor_explorers.env import FREE, UNKNOWN, View, World, make_policy, scenario
from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.navigation.straight_paths import straight_path
from indoor_explorers.env.search.clusters import frontier_clusters, middles, nearest_cells
from indoor_explorers.env.search.pockets.labels import true_pockets
from indoor_explorers.env.sensing.lidar import lidar_model, new_scan, visible_cells
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.evaluation.site.pictures.drawing import cells, svg
from indoor_explorers.evaluation.site.pictures.map_marks import (
    BLUE,
    GOAL_MARK,
    GREEN,
    ORANGE,
    PURPLE,
    SKY,
    UAV_MARK,
    UNKNOWN_PATCH,
    VERMILLION,
    WALL_PATCH,
    goal_at,
    label_at,
    legend,
    line,
    mark,
    tint,
    uav_at,
)

#: The offices of all pictures but one, and the floor of that, which is like those that the estimates were learned from.
OFFICE: dict[str, Any] = {"map.height": 22, "map.width": 32, "lidar.range": 6.0}
FLOOR: dict[str, Any] = {"map.height": 80, "map.width": 112, "map.area": [400.0, 2000.0]}
#: Seed of a floor and steps that were flown there before what is shown: for decisions, trees, estimates and swarm, and
#: for the flight in sectors.
DECISIONS, TREES, ESTIMATES, SWARM, SECTORS = (29, 81), (36, 81), (4, 426), (30, 69), (42, 60)
#: Names of the initial plans of a swarm.
INITIAL = ("greedy", "Hungarian", "MinPos", "current goals")


def planner_pictures() -> dict[str, bytes]:
    """Return the SVG files of the page by name."""
    drawn = {
        "clusters": _clusters,
        "decisions": _decisions,
        "trees": _trees,
        "swarm": _swarm,
        "estimates": _estimates,
        "sectors": _sectors,
    }
    return {f"planner-{name}.svg": svg(draw) for name, draw in drawn.items()}


def _flown(
    policy: str, place: tuple[int, int], settings: dict[str, Any], name: str = "small-offices"
) -> tuple[World, list[Any], list[list[Cell]]]:
    """Fly a team at a place, given by seed and steps; return the world, the pilots, and the cells of each UAV."""
    world = World(scenario(name).with_settings(settings))
    world.reset([place[0]])
    team = range(world.scenario.team)
    pilots = make_pilots(make_policy(policy), world)
    trails = [[world.view(0, uav).cell] for uav in team]
    for step, _ in enumerate(rollout(world, ask_pilots(make_policy(policy), pilots, world)), start=1):
        for uav in team:
            trails[uav].append(world.view(0, uav).cell)
        if step == place[1]:
            break
    return world, [pilots[0, uav] for uav in team], trails


@cache
def _explored(place: tuple[int, int]) -> World:
    """Return a floor that one UAV has explored by flying to nearest frontiers."""
    settings, name = (FLOOR, "floors") if place == ESTIMATES else (OFFICE, "small-offices")
    return _flown("frontier-nearest", place, settings | {"team": 1}, name)[0]


def _pilot(policy: str, place: tuple[int, int]) -> tuple[Any, View]:
    """Return a pilot that has decided nothing yet, and the view that it decides from."""
    world = _explored(place)
    return make_policy(policy).pilot(world.briefing(0, 0)), world.view(0, 0)


def _cell(flat: Any, view: View) -> Cell:
    """Return the row and column of a flat cell."""
    row, col = divmod(int(flat), view.belief.shape[1])
    return row, col


def _clusters(figure: Figure) -> None:
    pilot, view = _pilot("frontier-joint", DECISIONS)
    clusters = frontier_clusters(view.belief, OFFICE["lidar.range"])
    problem = pilot.decision_problem(view, pilot.members(view))
    figure.set_size_inches(7.0, 3.0)
    left, right = figure.subplots(1, 2)
    cells(left, view.belief, f"{clusters.size} frontier clusters")
    for k in range(clusters.size):
        member = np.zeros(view.belief.size, np.bool_)
        member[clusters.cells[clusters.ends[k] : clusters.ends[k + 1]]] = True
        tint(left, member.reshape(view.belief.shape), (BLUE, ORANGE, GREEN, PURPLE, SKY)[k % 5], 1.0)
    uav_at(left, view.cell)
    cells(right, view.belief, "view gains of their nearest cells")
    best = int(problem.gains.argmax())
    tint(right, _in_view(view, _cell(problem.cells[best], view)), ORANGE, 0.55)
    rows, cols = np.divmod(problem.cells, view.belief.shape[1])
    right.scatter(cols, rows, 130 * problem.gains / problem.gains.max(), c=BLUE, edgecolors="white", lw=0.6)
    label_at(right, _cell(problem.cells[best], view), f"{problem.gains[best]:.0f}", color="white", path_effects=[])
    uav_at(right, view.cell)
    handles = [
        UAV_MARK,
        mark("its area is the view gain", marker="o", color=BLUE),
        Patch(color=to_rgba(ORANGE, 0.55), label="unknown cells in view from the largest one"),
        UNKNOWN_PATCH,
        WALL_PATCH,
    ]
    legend(figure, handles, 5)


def _in_view(view: View, cell: Cell) -> NDArray[np.bool_]:
    """Return the unknown cells in view of a cell, where unknown cells are transparent, (H, W)."""
    lidar = lidar_model(OFFICE["lidar.range"])
    scan, seen = new_scan(lidar), np.zeros(view.belief.size, np.bool_)
    seen[scan.cells[: visible_cells(view.belief, *cell, lidar, scan)]] = True
    return np.asarray(seen.reshape(view.belief.shape) & (view.belief == UNKNOWN))


def _decisions(figure: Figure) -> None:
    figure.set_size_inches(7.0, 2.4)
    for axes, name in zip(figure.subplots(1, 3), ("frontier-nearest", "frontier-latency", "frontier"), strict=True):
        pilot, view = _pilot(name, DECISIONS)
        stops = _planned(pilot, view)
        pilot.act(view)
        cells(axes, view.belief, name)
        for one, other in pairwise(stops):
            way = straight_path(view.belief, one, other)
            line(axes, way, color=GREEN, linewidth=1.2, linestyle=(0, (3, 1.5)))
        line(axes, pilot.navigator.path, color=BLUE)
        for number, stop in enumerate(stops[1:], start=2):
            label_at(axes, stop, str(number))
        goal_at(axes, pilot.goal)
        uav_at(axes, view.cell)
    handles = [
        UAV_MARK,
        GOAL_MARK,
        Line2D([], [], color=BLUE, linewidth=1.8, label="path to the goal"),
        Line2D([], [], color=GREEN, linewidth=1.2, linestyle=(0, (3, 1.5)), label="planned after it: 2, 3, ..."),
    ]
    legend(figure, handles, 4)


def _planned(pilot: Any, view: View) -> list[Cell]:
    """Return the places that a frontier planner plans to visit, in order; none where it plans for one."""
    if hasattr(pilot, "order"):
        return list(pilot.order(view))
    if hasattr(pilot, "decision_problem"):
        problem = pilot.decision_problem(view, pilot.members(view))
        factors = pilot.factors(view, problem, 0)
        sequence = pilot.sequence(problem, 0, factors * problem.gains, factors)
        return [_cell(problem.cells[k], view) for k in sequence if k >= 0]
    return []


def _trees(figure: Figure) -> None:
    figure.set_size_inches(7.0, 3.0)
    left, right = figure.subplots(1, 2)
    pilot, view = _pilot("rrt-nbv", TREES)
    pilot.act(view)
    cells(left, view.belief, "rrt-nbv: a tree in known space")
    _edges(left, pilot.tree)
    line(left, pilot.tree.vertices[pilot.branch] - 0.5, color=BLUE)
    pilots = [(left, pilot)]
    pilot, view = _pilot("rrt-frontier", TREES)
    pilot.act(view)
    cells(right, view.belief, "rrt-frontier: trees into unknown space")
    for tree in pilot.trees:
        _edges(right, tree)
    rows, cols = np.divmod(pilot.frontier, view.belief.shape[1])
    right.plot(cols, rows, linestyle="", marker="s", markersize=3.6, color=ORANGE, markeredgecolor="black", mew=0.4)
    line(right, pilot.navigator.path, color=BLUE)
    for axes, each in [*pilots, (right, pilot)]:
        goal_at(axes, each.goal)
        uav_at(axes, view.cell)
        axes.set(xlim=(-0.5, view.belief.shape[1] - 0.5), ylim=(view.belief.shape[0] - 0.5, -0.5))
    handles = [
        UAV_MARK,
        GOAL_MARK,
        Line2D([], [], color=PURPLE, linewidth=1.0, label="tree"),
        Line2D([], [], color=BLUE, linewidth=1.8, label="best branch; path to the goal"),
        mark("where edges leave known space", marker="s", markersize=4, color=ORANGE, markeredgecolor="black", mew=0.4),
    ]
    legend(figure, handles, 5)


def _edges(axes: Any, tree: Any) -> None:
    for vertex, parent in enumerate(tree.parents.tolist()):
        if parent >= 0:
            line(axes, tree.vertices[[vertex, parent]] - 0.5, color=PURPLE, linewidth=1.0, path_effects=None)


def _swarm(figure: Figure) -> None:
    joint, view = _joint_plan()
    figure.set_size_inches(7.0, 3.9)
    plans = [(name, goals[:, None]) for name, goals in zip(INITIAL, joint.initial, strict=True)]
    panels = figure.subplots(2, 3).ravel()
    for axes, (name, plan) in zip(panels, [*plans, ("joint plan of the swarm", joint.best)], strict=False):
        cells(axes, view.belief, name)
        for member, goals, colour, dashes in zip(
            joint.members, plan, (BLUE, VERMILLION), ("-", (0, (3, 1.2))), strict=True
        ):
            stops = [member.cell, *(_cell(joint.cells[k], view) for k in goals if k >= 0)]
            for one, other in pairwise(stops):
                line(axes, straight_path(view.belief, one, other), color=colour, linestyle=dashes, linewidth=1.6)
            for number, stop in enumerate(stops[1:], start=1):
                label_at(axes, stop, str(number), color=colour, fontweight="bold")
            uav_at(axes, member.cell, color=colour)
    panels[-1].set_axis_off()
    handles = [
        Line2D([], [], marker="o", color=BLUE, label="UAV 0 and its paths"),
        Line2D([], [], marker="o", color=VERMILLION, linestyle=(0, (3, 1.2)), label="UAV 1 and its paths"),
        mark("goals in the order of the plan", marker="$1$"),
        UNKNOWN_PATCH,
        WALL_PATCH,
    ]
    panels[-1].legend(handles=handles, loc="center")


def _joint_plan() -> tuple[Any, View]:
    """Return the next joint plan of two linked UAVs, and the view of UAV 0."""
    world, (pilot, mate), _ = _flown("pso", SWARM, OFFICE | {"team": 2, "radio.model": "unlimited"})
    while True:
        view, plans = world.view(0, 0), pilot.plans
        joint = pilot.joint_plan(view, pilot.members(view))
        actions = [pilot.act(view), mate.act(world.view(0, 1))]
        if pilot.plans > plans:
            return joint, view
        world.post(0, 0, pilot.message)
        world.post(0, 1, mate.message)
        world.step(np.array([actions]))


def _estimates(figure: Figure) -> None:
    pilot, view = _pilot("frontier-predictive", ESTIMATES)
    clusters = frontier_clusters(view.belief, pilot.briefing.lidar_range)
    truth = _explored(ESTIMATES).state.truth[0]
    field = pilot.steps_from(view, view.cell)
    away = nearest_cells(field, clusters)[1]
    estimated, true = pilot.estimates(view, clusters).sizes, true_pockets(view.belief, truth, field, clusters).sizes
    deferred = pilot.outlook(view, clusters, away).deferred
    figure.set_size_inches(7.0, 3.0)
    left, right = figure.subplots(1, 2, width_ratios=(1.15, 1))
    cells(left, view.belief, "frontier clusters")
    tint(left, (view.belief == UNKNOWN) & (truth == FREE), SKY, 0.45)
    tint(left, np.isin(np.arange(truth.size), clusters.cells).reshape(truth.shape), ORANGE, 0.9)
    names = ascii_uppercase[: clusters.size]
    for name, flat in zip(names, middles(clusters, truth.shape[1]), strict=True):
        label_at(left, _cell(flat, view), name, fontweight="bold", fontsize=6.5)
    uav_at(left, view.cell)
    places = np.arange(clusters.size)
    right.bar(places - 0.2, true, 0.36, color=SKY, label="true")
    right.bar(places + 0.2, estimated, 0.36, color="white", edgecolor=BLUE, hatch="////", label="estimated")
    right.set(ylabel="unknown free cells behind", title="sizes of the pockets", yscale="symlog")
    right.set_yticks([0, 1, 10, 100, 1000], ["0", "1", "10", "100", "1,000"])
    right.set_xticks(places, [f"{name}*" if late else name for name, late in zip(names, deferred, strict=True)])
    handles = [UAV_MARK, mark("frontier cluster", marker="s", color=ORANGE), *right.get_legend_handles_labels()[0]]
    handles.append(mark("deferred", marker="$*$"))
    handles.insert(2, Patch(color=to_rgba(SKY, 0.6), label="free, not seen yet"))
    legend(figure, handles, 6)


def _sectors(figure: Figure) -> None:
    world, pilots, trails = _flown("frontier", SECTORS, OFFICE | {"team": 4, "radio.model": "none"})
    shape = world.state.truth[0].shape
    every = np.argwhere(np.ones(shape, np.bool_)).astype(np.float64)
    factors = [
        pilot.out_of_contact.left_by_unheard(world.view(0, uav), every).reshape(shape)
        for uav, pilot in enumerate(pilots)
    ]
    figure.set_size_inches(7.0, 3.0)
    left, right = figure.subplots(1, 2)
    shown = left.imshow(factors[0], cmap="cividis", vmin=0, vmax=1, interpolation="nearest")
    left.set_axis_off()
    left.set_title("factor of UAV 0 on gains")
    figure.colorbar(shown, ax=left, shrink=0.7)
    cells(right, world.state.union[0], f"{SECTORS[1]} steps of frontier, no radio")
    hues, ends = (BLUE, ORANGE, GREEN, PURPLE), ("o", "s", "^", "D")
    for uav, (colour, end, trail) in enumerate(zip(hues, ends, trails, strict=True)):
        tint(right, np.argmax(factors, axis=0) == uav, colour, 0.3)
        line(right, trail, color=colour)
        uav_at(right, trail[-1], color=colour, marker=end)
    for axes in (left, right):
        goal_at(axes, trails[0][0], color="white", markeredgecolor="black")
    handles = [
        Line2D([], [], color=colour, marker=end, label=f"UAV {uav}: sector, flight")
        for uav, (colour, end) in enumerate(zip(hues, ends, strict=True))
    ]
    start = mark("start", marker="*", markersize=9, color="white", markeredgecolor="black")
    legend(figure, [*handles, start], 5)
