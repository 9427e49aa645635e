"""Routes on maps of several levels, flown by a simulated quadrotor: obstacles as boxes, setpoints, errors, the table.

``level_flights_pyflyt.py`` flies them and writes the file that is read here; neither site nor tests need PyFlyt.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise, product
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from indoor_explorers.evaluation.drawing.formatting import percent
from indoor_explorers.evaluation.site.studies.dynamics import path_errors, touches

MEASURED = Path(__file__).parent / "level_flights.csv"
#: Metres a second; and metres a second squared of setpoints that rest at each corner, None of those that do not.
SPEEDS, RESTS = (0.5, 1.0, 1.5, 2.0), {"moves on": None, "rests at corners": 1.0}
#: Seconds by which a setpoint that rests leads, as the controller commands 1 m/s for each metre from it.
LEAD = 1.0
#: Half the height, length and width in metres of PyFlyt's Crazyflie 2, and of a UAV of 0.4 x 0.4 x 0.2 m.
BODIES = {"body": (0.01, 0.045, 0.045), "large": (0.1, 0.2, 0.2)}
#: Hertz of the samples of a flight.
KEPT = 30

Points = NDArray[np.float64]
"""(..., 3) metres upwards, down and right in the map, from the corner of its lowest level."""


class Flight(NamedTuple):
    """What a UAV flew: T samples at :data:`KEPT` hertz."""

    seconds: float
    arrived: bool
    """Whether it got to the end of its route."""
    leg: NDArray[np.int64]
    """(T,) the leg of the route of each sample."""
    position: Points
    due: Points
    """Where it was to be."""
    touching: NDArray[np.bool_]
    """Whether it touched an obstacle since the last sample."""


def boxes(occupied: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return (B, 2, 3) boxes, first voxel and the one after the last, that cover the set voxels (L, H, W) once each."""
    left, found = occupied.copy(), []
    while left.any():
        start = np.array(np.unravel_index(left.argmax(), left.shape))
        stop = start + 1
        for axis in np.eye(3, dtype=np.int64)[::-1]:
            while (axis * (stop - left.shape) < 0).any() and left[_block(start, stop + axis)].all():
                stop = stop + axis
        left[_block(start, stop)] = False
        found.append((start, stop))
    return np.array(found, np.int64).reshape(-1, 2, 3)


def _block(start: NDArray[np.int64], stop: NDArray[np.int64]) -> tuple[slice, ...]:
    return tuple(slice(int(low), int(high)) for low, high in zip(start, stop, strict=True))


def corners(voxels: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the voxels (K, 3) of a track (S, 3) where it turns, and its ends: stays and straight runs are left out."""
    track = voxels[np.r_[True, np.diff(voxels, axis=0).any(axis=1)]]
    steps = np.diff(track, axis=0)
    turns: NDArray[np.int64] = track[np.r_[True, (steps[1:] != steps[:-1]).any(axis=1), True][: len(track)]]
    return turns


def progress(length: float, speed: float, acceleration: float | None, period: float) -> NDArray[np.float64]:
    """Return the (T,) metres along a leg after each period, from rest to rest unless ``acceleration`` is None."""
    if acceleration is None:
        return np.linspace(0.0, length, max(1, round(length / speed / period)) + 1)[1:]
    top = min(speed, math.sqrt(length * acceleration))
    ramp, total = top / acceleration, length / top + top / acceleration
    time = np.minimum(np.arange(1, math.ceil(total / period) + 1) * period, total)
    slow, last = np.minimum(time, ramp), np.maximum(0.0, time - total + ramp)
    metres: NDArray[np.float64] = top * (time - slow) + acceleration * (slow**2 - last**2) / 2
    return np.minimum(metres, length)


def setpoints(
    route: Points, speed: float, acceleration: float | None, period: float
) -> Iterator[tuple[int, Points, Points]]:
    """Yield the leg, where the UAV is to be, and the setpoint that it gets, each period."""
    for leg, (start, end) in enumerate(pairwise(route)):
        length = float(np.linalg.norm(end - start))
        along = progress(length, speed, acceleration, period)
        ahead = np.zeros_like(along) if acceleration is None else LEAD / period * np.diff(along, prepend=0.0)
        for metres, more in zip(along, ahead, strict=True):
            yield leg, start + (end - start) * metres / length, start + (end - start) * (metres + more) / length


def in_free(occupied: NDArray[np.bool_], resolution: float, position: Points, half: tuple[float, ...]) -> float:
    """Return the share of (T, 3) positions at which an upright body smaller than a voxel is in free ones only."""
    solid, free = np.pad(occupied, 1, constant_values=True), np.ones(len(position), np.bool_)
    for signs in product((-1, 1), repeat=3):
        voxel = np.floor((position + np.array(signs) * half) / resolution).astype(int) + 1
        free &= ~solid[tuple(np.clip(voxel, 0, np.array(solid.shape) - 1).T)]
    return float(free.mean())


def row_of(flight: Flight, route: Points, occupied: NDArray[np.bool_], resolution: float) -> dict[str, float | int]:
    """Return the measures of a flight."""
    late = np.linalg.norm(flight.position - flight.due, axis=1)
    beside = path_errors(route[:, None], flight.leg, flight.position[:, None])[:, 0]
    row: dict[str, float | int] = {"seconds": flight.seconds, "arrived": int(flight.arrived)}
    for name, errors in (("late", late), ("beside", beside)):
        found = (errors.mean(), np.quantile(errors, 0.95), errors.max())
        row |= {f"{name}_{key}_m": float(value) for key, value in zip(("mean", "95", "max"), found, strict=True)}
    row["contacts"] = touches(np.where(flight.touching, 0.0, 1.0)[:, None], 0.5)
    row["contact_s"] = float(flight.touching.sum()) / KEPT
    return row | {f"free_{name}": in_free(occupied, resolution, flight.position, half) for name, half in BODIES.items()}


def flight_table() -> Iterator[str]:
    """Yield the rows of the table of flights, over the buildings, in Markdown; of 95 % and most the largest."""
    for (route, setpoint, speed), flights in pd.read_csv(MEASURED).groupby(["route", "setpoint", "speed"], sort=False):
        weight = flights["seconds"] / flights["seconds"].sum()
        errors = (
            f"{(flights[f'{name}_mean_m'] * weight).sum():.2f}, "
            f"{flights[f'{name}_95_m'].max():.2f}, {flights[f'{name}_max_m'].max():.2f}"
            for name in ("late", "beside")
        )
        there = flights[flights["arrived"] == 1]
        cells = (
            *(route, setpoint, f"{speed:g}", f"{len(there)} of {len(flights)}"),
            f"{there['seconds'].sum() / there['grid_s'].sum():.2f}" if len(there) else "-",
            *errors,
            f"{flights['contacts'].sum()}",
            *(percent(float((flights[f"free_{body}"] * weight).sum())) for body in BODIES),
        )
        yield f"| {' | '.join(cells)} |"
