"""Ask ns-3 for the losses between the pairs of cells of ``radio_comparison.py``, and write ``radio_ns3.csv``.

Run manually, in an environment that has the project and ns-3 (``pip install -c constraints.txt -e . ns3``)::

    python -P -m indoor_explorers.evaluation.site.studies.radio_ns3

ns-3 is a tool beside the tests here, and no dependency of the project.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from indoor_explorers.evaluation.site.studies.radio_comparison import (
    MEASURED,
    Pair,
    RoomGrid,
    floors,
    pairs_of,
    room_grid,
)

#: Hertz; the 2.4 GHz band. It adds the same to all losses.
FREQUENCY = 2.4e9
#: Metres; a storey of ns-3 has a height, and UAVs fly half-way.
STOREY = 3.0
#: Metres between buildings, which ns-3 has in one plane, and from a UAV to the end of a row of rooms.
APART, BESIDE = 1000.0, 0.1
COLUMNS = ("seed", *Pair._fields, "rooms", "ns3_db", "ns3_walls_db", "ns3_shadowed_db")


class Buildings:
    """Buildings of ns-3, each an office of one storey and far from the others, and the losses in them."""

    def __init__(self, ns: Any) -> None:
        """Begin without any; ``ns`` is the namespace of ns-3."""
        self._ns = ns
        self._built: list[Any] = []
        self._model = ns.CreateObject[ns.HybridBuildingsPropagationLossModel]()
        self._model.SetAttribute("Frequency", ns.DoubleValue(FREQUENCY))
        self._one_metre = self.in_row_of_rooms(1.0, 0, beyond=0.0)

    def build(self, width: float, depth: float, across: int, down: int) -> float:
        """Add a building, its size in metres, with equal rooms; return the x of its corner, whose y is 0."""
        ns, left = self._ns, len(self._built) * APART
        building = ns.CreateObject[ns.Building]()
        building.SetBoundaries(ns.Box(left, left + width, 0.0, depth, 0.0, STOREY))
        building.SetBuildingType(ns.Building.Office)
        building.SetNFloors(1)
        building.SetNRoomsX(across)
        building.SetNRoomsY(down)
        self._built.append(building)
        return left

    def radio(self, x: float, y: float) -> tuple[Any, Any]:
        """Return a radio at a place inside of a building, and what ns-3 says about that place."""
        ns = self._ns
        mobility, place = (
            ns.CreateObject[ns.ConstantPositionMobilityModel](),
            ns.CreateObject[ns.MobilityBuildingInfo](),
        )
        mobility.SetPosition(ns.Vector(x, y, STOREY / 2))
        mobility.AggregateObject(place)
        place.MakeConsistent(mobility)
        if not place.IsIndoor():
            raise RuntimeError(f"ns-3 has no building at {x}, {y}")
        return mobility, place

    def in_row_of_rooms(self, metres: float, walls: int, beyond: float | None = None) -> float:
        """Return the loss between the ends of a row of rooms, with that many walls between them."""
        left = self.build(metres + 2 * BESIDE, 2 * BESIDE, walls + 1, 1)
        (one, _), (other, _) = (self.radio(left + BESIDE + x, BESIDE) for x in (0.0, metres))
        return float(self._model.GetLoss(one, other)) - (self._one_metre if beyond is None else beyond)

    def on_floor(self, left: float, grid: RoomGrid, ends: list[tuple[float, float]]) -> tuple[int, float, float]:
        """Return the walls of the grid between two (x, y) of a floor, the loss, and the loss with shadowing."""
        (one, at), (other, to) = (self.radio(x - grid.left + left, y - grid.top) for x, y in ends)
        walls = abs(at.GetRoomNumberX() - to.GetRoomNumberX()) + abs(at.GetRoomNumberY() - to.GetRoomNumberY())
        shadowed = -float(self._model.CalcRxPower(0.0, one, other))
        return walls, float(self._model.GetLoss(one, other)) - self._one_metre, shadowed - self._one_metre


def rows(ns: Any) -> Iterator[list[Any]]:
    """Yield the rows of the file."""
    buildings = Buildings(ns)
    for seed, plan in floors():
        grid, side = room_grid(plan), plan.resolution or 1.0
        left = buildings.build(grid.right - grid.left, grid.bottom - grid.top, grid.across, grid.down)
        for pair in pairs_of(seed, plan):
            ends = [((col + 0.5) * side, (row + 0.5) * side) for row, col in (pair[:2], pair[2:4])]
            rooms, loss, shadowed = buildings.on_floor(left, grid, ends)
            walled = buildings.in_row_of_rooms(math.dist(*ends), pair.walls)
            yield [seed, *pair, rooms, *(f"{decibels:.3f}" for decibels in (loss, walled, shadowed))]


def main(out: Path = MEASURED) -> None:
    """Write the file."""
    from ns import ns

    ns.RngSeedManager.SetSeed(1)
    with out.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows(ns))


if __name__ == "__main__":
    main()
