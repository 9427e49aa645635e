"""The picture of a map's graph of rooms and doors."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from indoor_explorers.env import FREE, OCCUPIED
from indoor_explorers.env.maps.room_graph import CORRIDOR, DOOR, ROOM, nodes_of, room_graph
from indoor_explorers.env.maps.sources import FloorsMaps
from indoor_explorers.evaluation.site.pictures.drawing import cells, svg
from indoor_explorers.evaluation.site.pictures.map_marks import BLUE, GREEN, ORANGE, RIM, legend, line, mark

#: The generated floor that is shown.
FLOOR, SEED = FloorsMaps(height=64, width=112, area=(500.0, 700.0), turned=0.0, ragged=0.0, furniture=0.0), 5
#: How each kind of node is drawn.
LOOK: dict[str, dict[str, Any]] = {
    ROOM: {"marker": "o", "markersize": 8, "color": BLUE},
    CORRIDOR: {"marker": "s", "markersize": 7, "color": GREEN},
    DOOR: {"marker": "D", "markersize": 4, "color": ORANGE},
}


def map_pictures() -> dict[str, bytes]:
    """Return the SVG files about maps by name."""
    return {"maps-room-graph.svg": svg(_room_graph)}


def _room_graph(figure: Figure) -> None:
    """Draw a floor, its rooms and corridors, and the doors between them."""
    drawn = FLOOR.draw(np.random.default_rng(SEED))
    free = np.pad(drawn[np.ix_(drawn.any(axis=1), drawn.any(axis=0))], 1)
    graph = room_graph(free)
    figure.set_size_inches(7.2, 4.6)
    axes = figure.add_subplot()
    cells(axes, np.where(free, FREE, OCCUPIED), "")
    places = dict(graph.nodes(data="place"))
    for door, part in graph.edges:
        line(axes, [places[door], places[part]], color="#555555", linewidth=1.2)
    for kind, look in LOOK.items():
        for node in nodes_of(graph, kind):
            row, col = places[node]
            axes.plot(col, row, linestyle="", path_effects=RIM, zorder=5, **look)
    legend(figure, [mark(kind, **look | {"color": look["color"]}) for kind, look in LOOK.items()], 3)
