"""Fly recorded episodes with a quadrotor of PyFlyt, and write ``dynamics.csv`` and ``dynamics_tracks.csv``.

Run manually, in an environment that has the project and PyFlyt (``pip install -c constraints.txt -e . PyFlyt``)::

    python -P -m indoor_explorers.evaluation.site.studies.dynamics_pyflyt

PyFlyt is a tool beside the tests here, and no dependency of the project. The UAVs of a team fly together, each through
the centres of its cells, by PyFlyt's own position controller. Walls are no part of the physics: how often a UAV of a
given radius would touch one is computed from the true map afterwards.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import make_policy, scenario
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.site.studies.dynamics import (
    COLUMNS,
    DRAWN,
    DRAWN_STEPS,
    FLIGHTS,
    HOVER,
    MEASURED,
    POLICY,
    RADII,
    SCENARIO,
    SEEDS,
    TRACKS,
    Track,
    clearances,
    path_errors,
    touches,
)

#: Metres that the UAVs fly above ground, and seconds in which they come to rest there before the first step.
HEIGHT, SETTLED = 1.0, 3.0
#: A waypoint that is held has been reached within that many metres; seconds after which a flight has failed.
REACHED, LONGEST = 0.2, 60.0
#: Seconds that the team hovers at its starts, for comparison.
HOVERED = 60
#: Hertz of the track that is kept, of 120 Hz at which the controller runs, and of the track that is drawn.
KEPT, WRITTEN = 30, 5
#: The mode of PyFlyt's quadrotor whose setpoint is (x, y, yaw, z).
POSITION = 7
#: PyFlyt's Crazyflie 2: newtons of a motor at full throttle (its ``cf2x.yaml``), its mass in kg, and metres of a
#: propeller's radius; kg/m^3 of air and m/s^2.
FULL_THRUST, MASS, PROPELLER, AIR, GRAVITY = 0.5, 0.027, 0.0231, 1.225, 9.81


class Flight(NamedTuple):
    """What a team flew: samples at :data:`KEPT` hertz."""

    seconds: float
    joules: float
    step: NDArray[np.int64]
    """(T,) the step of the episode of each sample."""
    position: NDArray[np.float64]
    """(T, N, 2) metres down and right of the map's corner."""
    setpoint: NDArray[np.float64]
    """(T, N, 2) where the controller was to be."""


def induced_power(throttle: NDArray[np.float64]) -> float:
    """Return the watts that (4,) motors need at least for their thrust, by momentum theory (an actuator disk each)."""
    thrust = FULL_THRUST * throttle**2
    return float((thrust**1.5).sum() / math.sqrt(2 * AIR * math.pi * PROPELLER**2))


def hover_power() -> float:
    """Return the same for hovering."""
    return induced_power(np.full(4, math.sqrt(MASS * GRAVITY / 4 / FULL_THRUST)))


class Team:
    """Quadrotors in PyFlyt."""

    def __init__(self, starts: NDArray[np.float64], seed: int) -> None:
        """Let them hover above (N, 2) starts."""
        from PyFlyt.core import Aviary

        places = np.column_stack((starts[:, 1], -starts[:, 0], np.full(len(starts), HEIGHT)))
        self._aviary: Any = Aviary(places, np.zeros_like(places), drone_type="quadx", seed=seed)
        self._aviary.set_mode(POSITION)
        self.period = float(self._aviary.update_period)
        self._watts = 0.0
        for _ in range(round(SETTLED / self.period)):
            self.move(starts)

    def move(self, setpoints: NDArray[np.float64]) -> NDArray[np.float64]:
        """Fly one period towards (N, 2) setpoints; return the (N, 2) positions."""
        for number, (down, right) in enumerate(setpoints):
            self._aviary.set_setpoint(number, np.array([right, -down, 0.0, HEIGHT]))
        self._aviary.step()
        self._watts = sum(induced_power(self._aviary.aux_state(number)) for number in range(len(setpoints)))
        x, y = np.array([self._aviary.state(number)[3][:2] for number in range(len(setpoints))]).T
        return np.column_stack((-y, x))

    @property
    def joules(self) -> float:
        """The energy of the last period, of all together."""
        return self._watts * self.period

    def close(self) -> None:
        """End the simulation."""
        self._aviary.disconnect()


def flown(path: NDArray[np.float64], seconds: float | None, seed: int) -> Flight:
    """Fly an (S + 1, N, 2) path in metres: a step lasts ``seconds``, or None: until the team is there."""
    team = Team(path[0], seed)
    every, joules, periods = round(1 / KEPT / team.period), 0.0, 0
    samples: list[tuple[int, NDArray[np.float64], NDArray[np.float64]]] = []
    for step, (start, end) in enumerate(pairwise(path)):
        for setpoint in _setpoints(start, end, seconds, team.period):
            position = team.move(setpoint)
            joules += team.joules
            periods += 1
            if periods % every == 0:
                samples.append((step, position, setpoint))
            if seconds is None and (np.hypot(*(position - end).T) <= REACHED).all():
                break
        else:
            if seconds is None:
                raise RuntimeError(f"the team did not reach its waypoints of step {step} within {LONGEST} s")
    team.close()
    steps, positions, setpoints = (np.array(column) for column in zip(*samples, strict=True))
    return Flight(periods * team.period, joules, steps, positions, setpoints)


def _setpoints(
    start: NDArray[np.float64], end: NDArray[np.float64], seconds: float | None, period: float
) -> Iterator[NDArray[np.float64]]:
    """Yield the setpoints of a step: moving from start to end, or the end until it is left."""
    count = round((LONGEST if seconds is None else seconds) / period)
    for number in range(1, count + 1):
        yield end if seconds is None else start + (end - start) * number / count


def row_of(seed: int, name: str, flight: Flight, path: NDArray[np.float64], plan: Floorplan) -> dict[str, Any]:
    """Return the row of a flight in the file."""
    errors = np.hypot(*np.moveaxis(flight.position - flight.setpoint, -1, 0))
    beside = path_errors(path, flight.step, flight.position)
    clear = clearances(plan.truth, flight.position / (plan.resolution or 1.0)) * (plan.resolution or 1.0)
    apart = np.hypot(*(flight.position[:, 0] - flight.position[:, 1]).T)
    found: tuple[Any, ...] = (
        seed,
        name,
        len(path) - 1,
        f"{flight.seconds / (len(path) - 1):.3f}",
        *(f"{value:.3f}" for value in (errors.mean(), errors.max(), beside.mean(), beside.max())),
        f"{flight.joules / path.shape[1]:.1f}",
        f"{flight.joules / (hover_power() * flight.seconds * path.shape[1]):.4f}",
        *(touches(clear, radius) for radius in RADII),
        f"{clear.min():.3f}",
        f"{apart.min():.3f}",
    )
    return dict(zip(COLUMNS, found, strict=True))


def main() -> None:
    """Write both files."""
    task = scenario(SCENARIO).for_evaluation()
    tasks = [Task(task.name, 0, seed) for seed in SEEDS]
    records = fly(make_policy(POLICY), POLICY, task, tasks, bounds=dict.fromkeys(tasks, 1))
    with MEASURED.open("w", newline="") as file, TRACKS.open("w", newline="") as tracks:
        writer, drawn = csv.DictWriter(file, COLUMNS, lineterminator="\n"), csv.writer(tracks, lineterminator="\n")
        writer.writeheader()
        drawn.writerow(Track._fields)
        for record in records:
            plan, seed = record.floorplan, record.task.seed
            path = (record.cells.astype(np.float64) + 0.5) * (plan.resolution or 1.0)
            paths = {name: path for name in FLIGHTS} | {HOVER: np.repeat(path[:1], HOVERED + 1, axis=0)}
            for name, each in paths.items():
                speed = FLIGHTS.get(name)
                seconds = 1.0 if name == HOVER else None if speed is None else (plan.resolution or 1.0) / speed
                flight = flown(each, seconds, seed)
                writer.writerow(row_of(seed, name, flight, each, plan))
                file.flush()
                if seed == DRAWN and name != HOVER:
                    for step, place in list(zip(flight.step, flight.position, strict=True))[:: KEPT // WRITTEN]:
                        if step < DRAWN_STEPS:
                            drawn.writerow([name, step, *np.round(place.ravel(), 2).tolist()])


if __name__ == "__main__":
    main()
