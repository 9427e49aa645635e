"""Settings of training flights, drawn at random: teams with their radios, and lidars in buildings of several levels."""

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


def lidar_over_levels(plan: Floorplan, rng: np.random.Generator) -> dict[str, Any]:
    """Return the settings of a lidar that is drawn at random for a map of several levels."""
    reach, elevation = float(rng.choice(VOLUME_RANGES)), float(rng.choice(ELEVATIONS, p=ELEVATION_SHARES))
    return {"lidar.range": reach, "map.least_levels": plan.level_count, "lidar.elevation": elevation}


def team_settings(team: int, rng: np.random.Generator) -> dict[str, Any]:
    """Return the settings of a number of UAVs: a team has a radio drawn at random, a single one a random start."""
    return {"team": team} | ({"spawn": "random"} if team == 1 else RADIOS[rng.integers(len(RADIOS))])
