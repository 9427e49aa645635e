"""The pictures of teams on the page on planners: the joint plan of a swarm, and sectors without radio."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from indoor_explorers.env import View
from indoor_explorers.evaluation.site.pictures.drawing import cells
from indoor_explorers.evaluation.site.pictures.map_marks import (
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
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
from indoor_explorers.evaluation.site.pictures.planner_views import OFFICE, SECTORS, SWARM, cell_of, flown
from indoor_explorers.planners.toolbox.navigation.straight_paths import straight_path

#: Names of the initial plans of a swarm.
INITIAL = ("greedy", "Hungarian", "MinPos", "current goals")


def swarm(figure: Figure) -> None:
    """Draw the initial plans of a swarm and its joint plan."""
    joint, view = joint_plan()
    figure.set_size_inches(7.0, 3.9)
    plans = [(name, goals[:, None]) for name, goals in zip(INITIAL, joint.initial, strict=True)]
    panels = figure.subplots(2, 3).ravel()
    for axes, (name, plan) in zip(panels, [*plans, ("joint plan of the swarm", joint.best)], strict=False):
        cells(axes, view.belief, name)
        for member, goals, colour, dashes in zip(
            joint.members, plan, (BLUE, VERMILLION), ("-", (0, (3, 1.2))), strict=True
        ):
            stops = [member.cell, *(cell_of(joint.cells[k], view) for k in goals if k >= 0)]
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


def joint_plan() -> tuple[Any, View]:
    """Return the next joint plan of two linked UAVs, and the view of UAV 0."""
    world, (pilot, mate), _ = flown("pso", SWARM, OFFICE | {"team": 2, "radio.model": "unlimited"})
    while True:
        view, plans = world.view(0, 0), pilot.plans
        joint = pilot.joint_plan(view, pilot.members(view))
        actions = [pilot.act(view), mate.act(world.view(0, 1))]
        if pilot.plans > plans:
            return joint, view
        world.post(0, 0, pilot.message)
        world.post(0, 1, mate.message)
        world.step(np.array([actions]))


def sectors(figure: Figure) -> None:
    """Draw the factors of UAV 0 without radio, and the flight of the team in its sectors."""
    world, pilots, trails = flown("frontier", SECTORS, OFFICE | {"team": 4, "radio.model": "none"})
    shape = world.state.truth[0].shape
    every = np.argwhere(np.ones(shape, np.bool_)).astype(np.float64)
    factors = [
        pilot.chooser.out_of_contact.left_by_unheard(world.view(0, uav), every).reshape(shape)
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
