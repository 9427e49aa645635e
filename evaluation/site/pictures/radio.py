"""The pictures of the page on the radio beside ns-3, drawn from the measured losses."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from indoor_explorers.evaluation.drawing.palette import COLOURS
from indoor_explorers.evaluation.site.pictures.drawing import plan_map, svg
from indoor_explorers.evaluation.site.studies.radio_comparison import (
    DEFAULTS,
    METRES,
    contacts,
    floors,
    loss,
    measured,
    room_grid,
)

BLUE, ORANGE, GREY = COLOURS[0][0], COLOURS[1][0], "#888888"
#: The floor that is drawn, and how many of its pairs.
FLOOR, DRAWN = 6, 4
#: The range in the open of the contacts that are drawn, and the width of a bin of distances, in metres.
RANGE, BIN = 20.0, 2.5
DEFAULT_MODEL = "`path-loss`, defaults"


def radio_pictures() -> dict[str, bytes]:
    """Return the SVG files of the page by name."""
    return {"radio-walls.svg": svg(_walls), "radio-losses.svg": svg(_losses)}


def _walls(figure: Figure) -> None:
    figure.set_size_inches(7.0, 2.9)
    left, right = figure.subplots(1, 2)
    plan = dict(floors())[FLOOR]
    grid, side = room_grid(plan), plan.resolution or 1.0
    links = _links(FLOOR)
    for axes, title in (
        (left, "The floor: walls between two UAVs"),
        (right, f"ns-3: walls between, {grid.across} x {grid.down} rooms"),
    ):
        axes.set(title=title, aspect="equal")
        axes.set(xlim=(grid.left - 1, grid.right + 1), ylim=(grid.bottom + 1, grid.top - 1), xticks=[], yticks=[])
        axes.spines[:].set_visible(False)
        for link in links:
            ys, xs = (np.array([link[row], link[row + 2]]) * side + side / 2 for row in (0, 1))
            axes.plot(xs, ys, "o-", color=ORANGE, markersize=3, linewidth=1.4)
            count = link[4] if axes is left else link[5]
            box = {"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": ORANGE, "linewidth": 0.8}
            axes.text(xs.mean(), ys.mean(), count, color=ORANGE, weight="bold", ha="center", va="center", bbox=box)
    wall: dict[str, Any] = {"color": "#30343b", "linewidth": 0.9}
    plan_map(left, plan, wall["color"])
    right.hlines(np.linspace(grid.top, grid.bottom, grid.down + 1), grid.left, grid.right, **wall)
    right.vlines(np.linspace(grid.left, grid.right, grid.across + 1), grid.top, grid.bottom, **wall)


def _links(seed: int) -> list[tuple[int, ...]]:
    """Return some pairs of a floor of about the range, with their walls on the floor and in the grid."""
    table = measured()
    table = table[(table["seed"] == seed) & table["metres"].between(RANGE - 4, RANGE + 4)].head(DRAWN)
    return [tuple(row) for row in table[["row", "col", "to_row", "to_col", "walls", "rooms"]].itertuples(index=False)]


def _losses(figure: Figure) -> None:
    figure.set_size_inches(7.0, 3.0)
    left, right = figure.subplots(1, 2)
    pairs = measured()
    ours, ns3 = loss(pairs, *DEFAULTS), pairs["ns3_db"].to_numpy()
    left.plot(ours, ns3, ".", color=BLUE, markersize=2.5, alpha=0.55)
    ends = [0.0, float(max(ours.max(), ns3.max()))]
    left.plot(ends, ends, color=GREY, linewidth=0.8)
    left.set(xlabel="loss by path-loss [dB beyond 1 m]", ylabel="loss by ns-3 [dB beyond 1 m]", aspect="equal")
    left.set(xticks=range(0, 126, 25), yticks=range(0, 126, 25))
    left.set_title(f"{len(pairs)} pairs of cells on 10 floors")
    _by_distance(right)


def _by_distance(axes: Any) -> None:
    """Draw the share of pairs in contact by distance."""
    pairs = measured()
    found = contacts(pairs, RANGE)
    bins = (pairs["metres"].to_numpy() // BIN).astype(int)
    centres = [(k + 0.5) * BIN for k in range(int(METRES[1] / BIN))]
    for name, label, colour, style in (
        (DEFAULT_MODEL, "path-loss", BLUE, "-"),
        ("ns-3", "ns-3", ORANGE, "-"),
        ("ns-3, shadowed", "ns-3 with shadowing", ORANGE, (0, (3, 1.5))),
    ):
        shares = [found[name][bins == k].mean() for k in range(len(centres))]
        axes.plot(centres, shares, color=colour, linestyle=style, linewidth=1.4, label=label)
    axes.axvline(RANGE, color=GREY, linewidth=0.8, linestyle=(0, (4, 3)))
    axes.annotate("range in\nthe open", (RANGE, 0.9), (4, 0), textcoords="offset points", color="#555555")
    axes.set(xlabel="distance [m]", xlim=(0, METRES[1]), ylim=(0, 1.02), title="Share of pairs in contact")
    axes.set(yticks=[0, 0.5, 1], yticklabels=["0 %", "50 %", "100 %"])
    axes.legend(loc="center right", frameon=True, facecolor="white", edgecolor="none", framealpha=1.0)
