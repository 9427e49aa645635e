"""The pictures of the page on planners: real decisions on generated floors, read from the pilots that make them."""

from __future__ import annotations

from itertools import pairwise
from string import ascii_uppercase
from typing import Any

import numpy as np
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from indoor_explorers.env import FREE, UNKNOWN, View
from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.sensing.lidar import lidar_model, new_scan, visible_cells
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
    WALL_PATCH,
    goal_at,
    label_at,
    legend,
    line,
    mark,
    tint,
    uav_at,
)
from indoor_explorers.evaluation.site.pictures.planner_teams import sectors, swarm
from indoor_explorers.evaluation.site.pictures.planner_views import (
    DECISIONS,
    ESTIMATES,
    OFFICE,
    TREES,
    cell_of,
    explored,
    pilot_at,
)
from indoor_explorers.planners.toolbox.frontiers.clusters import frontier_clusters, middles, nearest_cells
from indoor_explorers.planners.toolbox.navigation.straight_paths import straight_path
from indoor_explorers.planners.toolbox.pockets.labels import true_pockets


def planner_pictures() -> dict[str, bytes]:
    """Return the SVG files of the page by name."""
    drawn = {
        "clusters": _clusters,
        "estimates": _estimates,
        "decisions": _decisions,
        "trees": _trees,
        "swarm": swarm,
        "sectors": sectors,
    }
    return {f"planner-{name}.svg": svg(draw) for name, draw in drawn.items()}


def _clusters(figure: Figure) -> None:
    pilot, view = pilot_at("frontier-joint", DECISIONS)
    clusters = frontier_clusters(view.belief, OFFICE["lidar.range"])
    problem = pilot.chooser.decision_problem(view, pilot.chooser.members(view))
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
    tint(right, _in_view(view, cell_of(problem.cells[best], view)), ORANGE, 0.55)
    rows, cols = np.divmod(problem.cells, view.belief.shape[1])
    right.scatter(cols, rows, 130 * problem.gains / problem.gains.max(), c=BLUE, edgecolors="white", lw=0.6)
    label_at(right, cell_of(problem.cells[best], view), f"{problem.gains[best]:.0f}", color="white", path_effects=[])
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
        pilot, view = pilot_at(name, DECISIONS)
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
    if hasattr(pilot, "chooser"):
        problem = pilot.chooser.decision_problem(view, pilot.chooser.members(view))
        factors = pilot.chooser.factors(view, problem, 0)
        sequence = pilot.chooser.sequence(problem, 0, factors * problem.gains, factors)
        return [cell_of(problem.cells[k], view) for k in sequence if k >= 0]
    return []


def _trees(figure: Figure) -> None:
    figure.set_size_inches(7.0, 3.0)
    left, right = figure.subplots(1, 2)
    pilot, view = pilot_at("rrt-nbv", TREES)
    pilot.act(view)
    cells(left, view.belief, "rrt-nbv: a tree in known space")
    _edges(left, pilot.tree)
    line(left, pilot.tree.vertices[pilot.branch] - 0.5, color=BLUE)
    pilots = [(left, pilot)]
    pilot, view = pilot_at("rrt-frontier", TREES)
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


def _estimates(figure: Figure) -> None:
    pilot, view = pilot_at("frontier-predictive", ESTIMATES)
    clusters = frontier_clusters(view.belief, pilot.briefing.lidar_range)
    truth = explored(ESTIMATES).state.truth[0]
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
        label_at(left, cell_of(flat, view), name, fontweight="bold", fontsize=6.5)
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
