"""The pictures of the page on where learning pays: the tasks of suite ``atlas``, and what learned parts are worth."""

from __future__ import annotations

import io
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from PIL import Image

from indoor_explorers.env.rendering import scene_of
from indoor_explorers.env.rendering.side_by_side import SideBySide, paint_side_by_side
from indoor_explorers.evaluation.cli.watch import WatchedFlight
from indoor_explorers.evaluation.drawing.palette import COLOURS
from indoor_explorers.evaluation.drawing.print_style import print_style
from indoor_explorers.evaluation.exports.figures.planner_figure import planner_figures
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.harness.results.ratios import POOLED
from indoor_explorers.evaluation.site.pictures.drawing import svg, svg_of
from indoor_explorers.evaluation.site.studies.atlas import LEARNED, Part, of_part, parts, planner_rows, short

#: Inches of the picture of the parts, and of a row.
WIDTH, ROW = 7.0, 0.27
#: Looks of the two times, and how far above and below the middle of a row they stand.
TIMES: dict[str, dict[str, Any]] = {
    "t90": {"color": COLOURS[1][0], "marker": "s", "markersize": 3.5},
    "t99": {"color": COLOURS[0][0], "marker": "o", "markersize": 4.0},
}
APART = {"t90": -0.16, "t99": 0.16}
#: The ratios that the axis holds.
LEAST, MOST = 0.78, 1.55


class Replay(NamedTuple):
    """An episode of the suite flown by two policies."""

    policies: tuple[str, str]
    scenario: str
    seed: int
    steps: int


#: The learner fetches the rooms beside a hall on its way, and is done when the planner has them still to fetch.
HALL = Replay(("frontier-predictive", "dddqn"), "halls", 32_000_018, 421)


def atlas_pictures() -> dict[str, bytes]:
    """Return the SVG files of the page by name."""
    with print_style():
        tasks = svg_of(planner_figures(planner_rows())[0])
    return {"atlas-planners.svg": tasks, "atlas-parts.svg": svg(_parts), "atlas-hall.png": replay()}


def replay() -> bytes:
    """Return the PNG file of one hall, flown by both policies of :data:`HALL` for as many steps."""
    shown = []
    for policy in HALL.policies:
        request = ComparisonRequest(policies=[policy], scenario=[HALL.scenario], team=1, episodes=1, seed=HALL.seed)
        flight = WatchedFlight(plan(request), 0, HALL.steps)
        for _ in flight.moments():
            pass
        shown.append(SideBySide(policy, scene_of(flight.world, 0, flight.trails), flight.coverage))
    file = io.BytesIO()
    Image.fromarray(paint_side_by_side(shown, HALL.steps)).save(file, "png")
    return file.getvalue()


def _parts(figure: Figure) -> None:
    names = [name for name in dict.fromkeys(parts()["scenario"]) if name != POOLED] + [POOLED]
    figure.set_size_inches(WIDTH, ROW * len(names) + 0.9)
    panels = figure.subplots(1, 2, sharey=True)
    for axes, part in zip(panels, LEARNED, strict=True):
        _panel(axes, of_part(part), part, names)
    panels[0].set(yticks=range(len(names)), yticklabels=[short(name) for name in names], ylim=(len(names) - 0.5, -0.5))
    legend = [Line2D([], [], linewidth=1.2, label=time.upper(), **look) for time, look in TIMES.items()]
    figure.legend(handles=legend, loc="outside lower center", ncols=2)


def _panel(axes: Any, table: pd.DataFrame, part: Part, names: list[str]) -> None:
    """Draw the ratios of a part by task, each with its interval; where there are none, how often 99 % were missed."""
    rows = {(row["scenario"], row["metric"]): row for row in table.to_dict("records")}
    for place, name in enumerate(names):
        for time, look in TIMES.items():
            row = rows.get((name, time))
            if row is not None and np.isfinite(row["mean_of_ratios"]):
                here = place + APART[time]
                axes.plot([row["low"], row["high"]], [here, here], color=look["color"], linewidth=1.2)
                axes.plot(row["mean_of_ratios"], here, linestyle="", **look)
        late = rows.get((name, "t99"))
        if late is not None and not np.isfinite(late["mean_of_ratios"]):
            both = late["never_both"]
            said = f"never 99 %: {late['never_policy'] + both}, without {late['never_baseline'] + both}"
            axes.text(MOST, place + APART["t99"], said, fontsize=6, color="#555555", ha="right", va="center")
    axes.axvline(1.0, color="black", linewidth=0.8)
    axes.axhline(len(names) - 1.5, color="#bbbbbb", linewidth=0.6)
    axes.set(xscale="log", xlim=(LEAST, MOST), xticks=(0.8, 0.9, 1, 1.1, 1.2, 1.4), xlabel="steps with it / without it")
    axes.set_xticklabels(["0.8", "0.9", "1", "1.1", "1.2", "1.4"])
    axes.minorticks_off()
    axes.grid(axis="x", color="#eeeeee", linewidth=0.6)
    axes.set_title(f"{part.title}:\n{part.policy} / {part.without}", fontsize=8)
