"""Fly a stored episode on a map of several levels with a quadrotor of PyFlyt, obstacles being solid boxes.

It needs PyFlyt, as :mod:`.dynamics_pyflyt` says. For each episode of one UAV, ::

    python -P -m indoor_explorers.evaluation.site.studies.level_flights_pyflyt DIR POLICY SCENARIO SEED

flies its first :data:`MOVES` moves in every way, and appends to ``level_flights.csv`` the flights that it lacks.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import OCCUPIED
from indoor_explorers.env.search.any_angle import straightened
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.site.studies.dynamics_pyflyt import POSITION, REACHED, SETTLED
from indoor_explorers.evaluation.site.studies.level_flights import (
    KEPT,
    MEASURED,
    RESTS,
    SPEEDS,
    Flight,
    Points,
    boxes,
    corners,
    row_of,
    setpoints,
)

#: How many moves of an episode are flown, from its start on.
MOVES = 60
#: Seconds after the last setpoint, and metres from where it is to be, that say that a UAV will not arrive.
LONGEST, LOST = 10.0, 5.0


class Uav:
    """A quadrotor in PyFlyt among obstacles."""

    def __init__(self, start: Points, occupied: NDArray[np.bool_], resolution: float, seed: int) -> None:
        """Let it hover at a start (3,) among the set voxels, and the border of the map, as boxes."""
        from PyFlyt.core import Aviary

        self._aviary: Any = Aviary(_xyz(start)[None], np.zeros((1, 3)), drone_type="quadx", seed=seed)
        for low, high in (boxes(np.pad(occupied, 1, constant_values=True)) - 1) * resolution:
            half = np.abs(_xyz(high - low)) / 2
            shape = self._aviary.createCollisionShape(self._aviary.GEOM_BOX, halfExtents=half)
            self._aviary.createMultiBody(0, shape, basePosition=_xyz((low + high) / 2))
        self._aviary.register_all_new_bodies()
        self._aviary.set_mode(POSITION)
        self.period = float(self._aviary.update_period)
        for _ in range(round(SETTLED / self.period)):
            self.move(start)

    def move(self, setpoint: Points) -> tuple[Points, bool]:
        """Fly one period towards a setpoint (3,); return the position, and whether it touches an obstacle."""
        x, y, z = _xyz(setpoint)
        self._aviary.set_setpoint(0, np.array([x, y, 0.0, z]))
        self._aviary.step()
        x, y, z = self._aviary.state(0)[3]
        return np.array([z, -y, x]), bool(self._aviary.contact_array[self._aviary.drones[0].Id].any())

    def close(self) -> None:
        """End the simulation."""
        self._aviary.disconnect()


def flown(
    route: Points, occupied: NDArray[np.bool_], resolution: float, speed: float, acceleration: float | None, seed: int
) -> Flight:
    """Fly a route (K, 3) among the set voxels until the UAV is at its end, or :data:`LOST`, or :data:`LONGEST` late."""
    uav, samples, touched = Uav(route[0], occupied, resolution, seed), [], False
    way = list(setpoints(route, speed, acceleration, uav.period))
    ends = len(way)
    way += [(len(route) - 2, route[-1], route[-1])] * round(LONGEST / uav.period)
    for number, (leg, due, setpoint) in enumerate(way, 1):
        position, touching = uav.move(setpoint)
        touched |= touching
        if number % round(1 / KEPT / uav.period) == 0:
            samples.append((leg, position, due, touched))
            touched = False
        arrived = number >= ends and bool(np.linalg.norm(position - route[-1]) <= REACHED)
        if arrived or np.linalg.norm(position - due) > LOST:
            break
    uav.close()
    legs, positions, dues, contacts = (np.array(column) for column in zip(*samples, strict=True))
    return Flight(number * uav.period, arrived, legs, positions, dues, contacts)


def _xyz(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return PyFlyt's x, y, z of (..., 3) metres upwards, down and right."""
    return np.stack((points[..., 2], -points[..., 1], points[..., 0]), axis=-1)


def rows(record: Record, flown_before: set[tuple[str, ...]]) -> Iterator[dict[str, Any]]:
    """Yield a row for each flight of an episode of one UAV, but those whose first cells are given."""
    plan, resolution = record.floorplan, record.floorplan.resolution or 1.0
    cells = np.ascontiguousarray(record.cells[: MOVES + 1, 0].astype(np.int64))
    occupied, moves = plan.levels.volume(plan.truth) == OCCUPIED, int(np.diff(cells, axis=0).any(axis=1).sum())
    routes = {"cell by cell": cells, "straightened": cells[straightened(plan.truth, cells)]}
    for (name, track), (rests, acceleration), speed in product(routes.items(), RESTS.items(), SPEEDS):
        facts = {"scenario": record.task.scenario, "seed": record.task.seed, "route": name, "setpoint": rests}
        facts |= {"speed": speed}
        if tuple(str(value) for value in facts.values()) in flown_before:
            continue
        route: Points = (corners(plan.levels.voxels(track)).astype(np.float64) + 0.5) * resolution
        flight = flown(route, occupied, resolution, speed, acceleration, record.task.seed)
        metres = float(np.linalg.norm(np.diff(route, axis=0), axis=1).sum())
        grid = {"moves": moves, "legs": len(route) - 1, "grid_s": moves * resolution / speed}
        measures = {"route_m": metres} | row_of(flight, route, occupied, resolution)
        yield facts | grid | {key: round(value, 4) for key, value in measures.items()}


def main(results: Path, policy: str, scenario: str, seed: int) -> None:
    """Fly an episode in every way, and append to the file the flights that it lacks."""
    (record,) = (
        each
        for each in Results.load(results).records
        if (each.policy, each.task.scenario, each.task.seed) == (policy, scenario, seed)
    )
    known = list(csv.reader(MEASURED.open(newline=""))) if MEASURED.exists() else []
    with MEASURED.open("a", newline="") as file:
        for row in rows(record, {tuple(cells[:5]) for cells in known}):
            writer = csv.DictWriter(file, row, lineterminator="\n")
            if file.tell() == 0:
                writer.writeheader()
            writer.writerow(row)
            file.flush()


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], sys.argv[3], int(sys.argv[4]))
