"""Recorded paths flown by a simulated quadrotor: tracking errors, touched walls, and the table of the page.

``dynamics_pyflyt.py`` flies them and writes the files that are read here; neither the site nor the tests need PyFlyt.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from indoor_explorers.env import OCCUPIED

MEASURED, TRACKS = (Path(__file__).parent / f"{name}.csv" for name in ("dynamics", "dynamics_tracks"))
#: The recorded episodes, that whose tracks are drawn, and how many of its steps.
SCENARIO, POLICY, SEEDS, DRAWN, DRAWN_STEPS = "small-floors", "frontier", range(4), 3, 45
#: Speed of the setpoints in metres a second; None: waypoints that wait for the team.
FLIGHTS: dict[str, float | None] = {"0.5 m/s": 0.5, "1 m/s": 1.0, "2 m/s": 2.0, "waypoints": None}
#: The flight that stays at the starts.
HOVER = "hover"
#: Radii of UAVs in metres whose touches are counted.
RADII = (0.1, 0.25, 0.4)
TOUCHES = tuple(f"touches_{round(100 * radius)}cm" for radius in RADII)
COLUMNS = (
    "seed",
    "flight",
    "steps",
    "step_s",
    "setpoint_mean_m",
    "setpoint_max_m",
    "path_mean_m",
    "path_max_m",
    "joules",
    "to_hover",
    *TOUCHES,
    "clearance_m",
    "apart_m",
)
#: Steps before and after that of a sample, whose parts of the path it may be compared with.
BEHIND, AHEAD = 8, 1


class Track(NamedTuple):
    """A row of the tracks: where two UAVs were, in metres down and right."""

    flight: str
    step: int
    down_0: float
    right_0: float
    down_1: float
    right_1: float


def path_errors(
    path: NDArray[np.float64], step: NDArray[np.int64], position: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the (T, N) distances of (T, N, 2) positions from the path (S + 1, N, 2) around their steps."""
    least = np.full(position.shape[:2], np.inf)
    for offset in range(-BEHIND, AHEAD + 1):
        at = np.clip(step + offset, 0, len(path) - 2)
        start, along = path[at], path[at + 1] - path[at]
        squared = (along**2).sum(axis=2)
        share = ((position - start) * along).sum(axis=2) / np.where(squared > 0, squared, 1.0)
        nearest = start + along * np.clip(share, 0.0, 1.0)[..., None]
        least = np.minimum(least, np.sqrt(((position - nearest) ** 2).sum(axis=2)))
    return least


def clearances(truth: NDArray[np.uint8], position: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (T, N) distances in cells of (T, N, 2) positions to the nearest occupied cell, up to one cell."""
    padded = np.pad(truth, 2, constant_values=OCCUPIED)
    cell = np.floor(position).astype(int)
    least = np.ones(position.shape[:2])
    for down in (-1, 0, 1):
        for right in (-1, 0, 1):
            row, col = cell[..., 0] + down, cell[..., 1] + right
            beside = np.abs(position - np.stack((row, col), axis=-1) - 0.5) - 0.5
            distance = np.sqrt((np.maximum(beside, 0.0) ** 2).sum(axis=-1))
            occupied = (
                padded[np.clip(row + 2, 0, padded.shape[0] - 1), np.clip(col + 2, 0, padded.shape[1] - 1)] == OCCUPIED
            )
            least = np.minimum(least, np.where(occupied, distance, np.inf))
    return least


def touches(clear: NDArray[np.float64], radius: float) -> int:
    """Count the times that UAVs of a radius begin to touch a wall, from their (T, N) clearances."""
    touching = clear < radius
    return int(touching[0].sum() + (touching[1:] & ~touching[:-1]).sum())


def measured() -> pd.DataFrame:
    """Return the rows of the flights."""
    table = pd.read_csv(MEASURED)
    table["joules_step"] = table["joules"] / table["steps"]
    return table


def flight_table() -> list[str]:
    """Return the rows of the table of flights over all episodes, in Markdown."""
    rows = []
    for name, flights in measured().groupby("flight", sort=False):
        steps = flights["steps"]
        mean = {column: (flights[column] * steps).sum() / steps.sum() for column in ("step_s", "joules_step")}
        weight = flights["step_s"] * steps
        error, beside = (
            (flights[column] * weight).sum() / weight.sum() for column in ("setpoint_mean_m", "path_mean_m")
        )
        cells = (
            str(name),
            f"{mean['step_s']:.3g}",
            f"{error:.2f}, {flights['setpoint_max_m'].max():.2f}",
            f"{beside:.2f}, {flights['path_max_m'].max():.2f}",
            f"{mean['joules_step']:.2f}",
            *(str(flights[column].sum()) for column in TOUCHES),
            f"{flights['apart_m'].min():.2f}",
        )
        rows.append(f"| {' | '.join(cells)} |")
    return rows
