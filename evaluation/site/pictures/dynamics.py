"""The picture of the page on dynamics: tracks of a quadrotor on a part of a floor, from the measured files."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from indoor_explorers.env import scenario
from indoor_explorers.evaluation.drawing.palette import COLOURS
from indoor_explorers.evaluation.site.pictures.drawing import plan_map, svg
from indoor_explorers.evaluation.site.studies.dynamics import DRAWN, FLIGHTS, SCENARIO, TRACKS

#: Metres around the tracks.
AROUND = 1.5


def dynamics_pictures() -> dict[str, bytes]:
    """Return the SVG files of the page by name."""
    return {"dynamics-tracks.svg": svg(_tracks)}


def _tracks(figure: Figure) -> None:
    tracks = pd.read_csv(TRACKS)
    plan = scenario(SCENARIO).map.floorplan(0, DRAWN)
    (left, right), (top, bottom) = (_extent(tracks[[f"{axis}_0", f"{axis}_1"]]) for axis in ("right", "down"))
    figure.set_size_inches(7.0, 7.0 * (bottom - top) / (right - left) + 0.5)
    for axes, name in zip(figure.subplots(2, 2).ravel(), FLIGHTS, strict=True):
        plan_map(axes, plan, "#c8ccd1")
        flight = tracks[tracks["flight"] == name]
        for uav in (0, 1):
            axes.plot(flight[f"right_{uav}"], flight[f"down_{uav}"], color=COLOURS[uav][0], linewidth=1.0)
        axes.set(xlim=(left, right), ylim=(bottom, top), title=name, xticks=[], yticks=[])
        axes.spines[:].set_visible(False)


def _extent(places: pd.DataFrame) -> tuple[float, float]:
    return float(places.min(axis=None)) - AROUND, float(places.max(axis=None)) + AROUND
