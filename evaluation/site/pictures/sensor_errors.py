"""The pictures of sensors and poses that err: maps with wrong cells, and fields of view."""

from __future__ import annotations

from itertools import count
from typing import Any, NamedTuple

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from indoor_explorers.env import FREE, OCCUPIED, UNKNOWN, Action, World, make_policy, scenario
from indoor_explorers.env.grid.cells import MOVES, TURN
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.evaluation.site.pictures.drawing import MARKED, UAV, cells, fly_steps, svg

#: Colours of cells that a map shows rightly as unknown, free and occupied, wrongly as occupied, and wrongly as free.
COLOURS = ("#9aa0a6", "#f4f4f4", "#30343b", "#cd3449", "#f7a8b6")
MAP, FALSE_OBSTACLE, FALSE_FREE = ListedColormap(COLOURS), 3, 4
#: How a UAV is marked where it is, and where it believes to be.
TRUE = UAV | {"color": "#b8860b", "markersize": 3}
BELIEVED = TRUE | {"markersize": 6.5, "markerfacecolor": "none"}
#: Where the UAV with a limited field of view is.
HERE = (7, 7)
#: The floor that is flown, for this many steps.
FLOOR, SEED, STEPS = "small-floors", 4, 400
DRIFT = {"drift.rate": 0.01}
#: Settings of the flights by title.
FLIGHTS: dict[str, dict[str, Any]] = {
    "exact": {},
    "noise": {"noise.misses": 0.1, "noise.false_returns": 0.005, "noise.range_std": 0.3},
    "drift": {**DRIFT, "drift.closures": 0.0, "drift.mates": False},
    "drift, loop closure": DRIFT,
}


def sensor_error_pictures() -> dict[str, bytes]:
    """Return the SVG files by name."""
    return {"errors-maps.svg": svg(_maps), "errors-view.svg": svg(_views)}


class Flown(NamedTuple):
    """The end of a flight."""

    codes: NDArray[np.uint8]
    """(H, W) codes of :data:`COLOURS` of the team's map."""
    cell: NDArray[np.int64]
    """(N, 2) where the UAVs are."""
    believed: NDArray[np.int64]
    """(N, 2) where they believe to be."""


def flown(settings: dict[str, Any]) -> Flown:
    """Fly the floor with errors."""
    world = World(scenario(FLOOR).for_evaluation().with_settings(settings))
    world.reset([SEED])
    fly_steps(world, make_policy("frontier-nearest"), STEPS)
    state = world.state
    shown, truth = state.union[0], state.truth[0]
    codes = np.where((shown == OCCUPIED) & (truth == FREE), FALSE_OBSTACLE, shown)
    codes[(shown == FREE) & (truth == OCCUPIED)] = FALSE_FREE
    return Flown(codes, state.cell[0].copy(), state.believed_cell[0].copy())


def _maps(figure: Figure) -> None:
    flights = {title: flown(settings) for title, settings in FLIGHTS.items()}
    shown = np.any([flight.codes != UNKNOWN for flight in flights.values()], axis=0)
    rows, cols = (np.flatnonzero(shown.any(axis=axis)) for axis in (1, 0))
    figure.set_size_inches(7.0, 0.6 + 7.0 / len(flights) * np.ptp(rows) / np.ptp(cols))
    for axes, (title, flight) in zip(figure.subplots(1, len(flights)), flights.items(), strict=True):
        wrong = np.isin(flight.codes, (FALSE_OBSTACLE, FALSE_FREE)).sum() / (flight.codes != UNKNOWN).sum()
        axes.imshow(flight.codes, cmap=MAP, vmin=0, vmax=FALSE_FREE, interpolation="nearest")
        for places, look in ((flight.cell, TRUE), (flight.believed, BELIEVED)):
            axes.plot(places[:, 1], places[:, 0], **look)
        axes.set(xlim=(cols[0] - 1.5, cols[-1] + 1.5), ylim=(rows[-1] + 1.5, rows[0] - 1.5))
        axes.set_axis_off()
        axes.set_title(f"{title}\n{100 * wrong:.1f} % wrong" if wrong else f"{title}\nnothing wrong")
    figure.legend(
        handles=[
            Patch(facecolor=COLOURS[FALSE_OBSTACLE], label="shown occupied, is free"),
            Patch(facecolor=COLOURS[FALSE_FREE], label="shown free, is occupied"),
            Line2D([], [], label="UAV", **TRUE),
            Line2D([], [], label="where it believes to be", **BELIEVED),
        ],
        loc="outside lower center",
        ncols=4,
        frameon=False,
        fontsize="small",
        handlelength=1.2,
        columnspacing=1.4,
    )


def _views(figure: Figure) -> None:
    figure.set_size_inches(7.0, 2.1)
    looks = ((360, False), (180, False), (90, False), (90, True))
    for axes, (degrees, turned) in zip(figure.subplots(1, len(looks)), looks, strict=True):
        world = _begun(degrees)
        if turned:
            world.step(np.array([[TURN]]))
        truth, heading = world.state.truth[0], world.view(0, 0).heading
        seen = (world.state.belief[0, 0] != UNKNOWN) & (truth == FREE)
        cells(axes, np.where(seen, MARKED, truth), f"{degrees} degrees" + ", turned" * turned, [HERE])
        if heading is not None:
            tip = np.array(HERE) + 2.2 * MOVES[heading]
            arrow = {"arrowstyle": "-|>", "color": UAV["color"], "linewidth": 1.6, "shrinkA": 0, "shrinkB": 0}
            axes.annotate("", tip[::-1], HERE[::-1], arrowprops=arrow)


def _begun(degrees: int) -> World:
    """Return an episode among obstacles that has begun, of the first seed with which the UAV faces up."""
    free = np.ones((15, 15), np.bool_)
    free[4, 3:9] = free[9:12, 4] = free[10, 9:13] = free[6:8, 11] = free[2, 12] = False
    plan = Floorplan.from_free(free, "obstacles")
    settings = {"lidar.range": 6.0, "lidar.field_of_view": float(degrees), "on_collision": "block"}
    world = World(scenario("thesis-open").with_settings(settings))
    for seed in count():
        world.begin(0, seed, floorplan=plan, spawns=[HERE])
        if world.view(0, 0).heading in (None, Action.UP):
            break
    return world
