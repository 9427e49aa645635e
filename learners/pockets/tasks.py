"""Settings of training flights, drawn at random: teams with their radios, harder tasks, and lidars over levels."""

from __future__ import annotations

import math
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

#: Lidar ranges in cells and numbers of UAVs of tasks with a home base, each with their shares of the flights.
BASE_RANGES, BASE_RANGE_SHARES = (10.0, 7.0, 14.0), (0.8, 0.1, 0.1)
BASE_TEAMS, BASE_TEAM_SHARES = (1, 2, 4), (0.2, 0.45, 0.35)
#: The radios of teams with a home base, with their shares.
BASE_RADIOS: tuple[dict[str, Any], ...] = (
    {"radio.model": "disc", "radio.range": 15.0},
    {"radio.model": "unlimited"},
    {"radio.model": "none"},
)
BASE_RADIO_SHARES = (0.8, 0.1, 0.1)
#: Least and most budget with a home base, in free cells by lidar range and team.
SHORTEST, LONGEST = 3.5, 11.0


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


def base_settings(free: int, rng: np.random.Generator) -> dict[str, Any]:
    """Return the settings of a task with a home base and a deadline, on a map of so many ``free`` cells, at random."""
    reach = float(rng.choice(BASE_RANGES, p=BASE_RANGE_SHARES))
    team = int(rng.choice(BASE_TEAMS, p=BASE_TEAM_SHARES))
    length = math.exp(rng.uniform(math.log(SHORTEST), math.log(LONGEST)))
    radio = BASE_RADIOS[rng.choice(len(BASE_RADIOS), p=BASE_RADIO_SHARES)] if team > 1 else {}
    base = {"base.at": "start", "base.must_return": True}
    return {"lidar.range": reach, "team": team, "budget": int(length * free / reach / team), **base, **radio}
