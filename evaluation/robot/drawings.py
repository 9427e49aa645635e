"""What an explorer shows: frontiers, the candidates of its pilot by score, its goal and its way, as lists of points."""

from __future__ import annotations

from typing import NamedTuple

from indoor_explorers.env.interfaces.ros import CUBE_LIST, LINE_STRIP, SPHERE_LIST
from indoor_explorers.evaluation.robot.bans import Point
from indoor_explorers.evaluation.robot.explorer import Explorer

Colour = tuple[float, float, float, float]

_FRONTIER, _GOAL, _WAY = (0.2, 0.5, 1.0, 0.6), (1.0, 0.2, 0.2, 0.9), (1.0, 0.6, 0.1, 0.9)


class Drawing(NamedTuple):
    """A list of points in metres, for one ``visualization_msgs/Marker``; without points it is to be deleted."""

    name: str
    kind: int
    size: float
    """Metres."""
    points: list[Point]
    colours: list[Colour]
    """A colour (red, green, blue, opacity) for each point."""


def drawings(explorer: Explorer) -> list[Drawing]:
    """Return frontiers, candidates, goal and way; candidates are the greener, the better."""
    frame, piloting = explorer.frame, explorer.piloting
    if frame is None or piloting is None:
        return []
    told = piloting.explain()
    candidates = [] if told is None or explorer.target is None else list(told.candidates)
    way = piloting.way if explorer.target is not None else []
    last = max(len(candidates) - 1, 1)
    shades: list[Colour] = [(k / last, 1 - k / last, 0.1, 0.9) for k in range(len(candidates))]
    frontiers = explorer.frontier_points()
    cell = frame.resolution
    return [
        Drawing("frontiers", CUBE_LIST, 0.8 * cell, frontiers, [_FRONTIER] * len(frontiers)),
        Drawing("candidates", SPHERE_LIST, 0.6 * cell, [frame.point(each.cell) for each in candidates], shades),
        Drawing("goal", SPHERE_LIST, cell, [frame.point(way[-1])] if way else [], [_GOAL] if way else []),
        Drawing("plan", LINE_STRIP, 0.15 * cell, [frame.point(each) for each in way], [_WAY] * len(way)),
    ]
