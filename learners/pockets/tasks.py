"""Settings of training flights, drawn at random: teams with their radios, harder tasks, and lidars over levels."""

from __future__ import annotations

from typing import Any

import numpy as np

from indoor_explorers.env.maps.floorplan import Floorplan

#: Radios of the teams of training flights, in equal shares.
RADIOS: tuple[dict[str, Any], ...] = (
    {"radio.model": "unlimited"},
    {"radio.model": "disc", "radio.range": 15.0},
    {"radio.model": "none"},
)
#: Lidar ranges in buildings of several levels, in equal shares, and degrees that the lidar looks up and down there,
#: with their shares.
VOLUME_RANGES = (4.0, 7.0, 10.0)
ELEVATIONS, ELEVATION_SHARES = (90.0, 15.0), (0.7, 0.3)
#: Kinds of harder tasks for teams and for single UAVs, with their shares.
HARDER = ("view", "noise", "drift", "stops", "outages"), (0.3, 0.1, 0.1, 0.3, 0.2)
HARDER_ALONE = ("view", "noise", "drift"), (0.6, 0.2, 0.2)
#: Fields of view in degrees, with their shares.
VIEWS, VIEW_SHARES = (90.0, 120.0, 180.0), (0.6, 0.2, 0.2)
#: The largest errors, and the largest probability that a UAV stops in a step.
LARGEST: dict[str, dict[str, float]] = {
    "noise": {"noise.misses": 0.2, "noise.false_returns": 0.005, "noise.range_std": 0.3},
    "drift": {"drift.rate": 0.002},
    "stops": {"failures.hazard": 0.003},
}


def lidar_over_levels(plan: Floorplan, rng: np.random.Generator) -> dict[str, Any]:
    """Return the settings of a lidar that is drawn at random for a map of several levels."""
    reach, elevation = float(rng.choice(VOLUME_RANGES)), float(rng.choice(ELEVATIONS, p=ELEVATION_SHARES))
    return {"lidar.range": reach, "map.least_levels": plan.level_count, "lidar.elevation": elevation}


def team_settings(team: int, rng: np.random.Generator) -> dict[str, Any]:
    """Return the settings of a number of UAVs: a team has a radio drawn at random, a single one a random start."""
    return {"team": team} | ({"spawn": "random"} if team == 1 else RADIOS[rng.integers(len(RADIOS))])


def harder_settings(team: int, rng: np.random.Generator) -> dict[str, Any]:
    """Return the settings of one harder task for a number of UAVs: a kind of it, and how hard it is, at random."""
    kinds, shares = HARDER if team > 1 else HARDER_ALONE
    kind = kinds[rng.choice(len(kinds), p=shares)]
    if kind == "view":
        return {"lidar.field_of_view": float(rng.choice(VIEWS, p=VIEW_SHARES))}
    if kind == "outages":
        return {
            "failures.radio_hazard": float(rng.uniform(0.005, 0.03)),
            "failures.radio_outage": int(rng.integers(20, 61)),
        }
    return {name: float(rng.uniform(0.0, most)) for name, most in LARGEST[kind].items()}
