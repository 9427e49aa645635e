"""Places that a robot could not reach: banned for a while, tried again, and given up after some failures."""

from __future__ import annotations

import math
from dataclasses import dataclass

#: Failures after which a place is given up.
MOST_STRIKES = 3

Point = tuple[float, float]


@dataclass
class _Ban:
    point: Point
    until: float
    strikes: int


class Bans:
    """Keep the banned places of a map, in metres; times are in seconds."""

    def __init__(self, seconds: float, radius: float) -> None:
        """Ban for some seconds; places at most ``radius`` metres apart are one."""
        self._seconds, self._radius = seconds, radius
        self._bans: list[_Ban] = []

    def add(self, point: Point, now: float, *, strike: bool = True) -> None:
        """Ban a place; without ``strike`` the failure was not the place's, as where a teammate was in the way."""
        ban = next((ban for ban in self._bans if math.dist(ban.point, point) <= self._radius), None)
        if ban is None:
            ban = _Ban(point, 0.0, 0)
            self._bans.append(ban)
        ban.until, ban.strikes = now + self._seconds, ban.strikes + strike

    def active(self, now: float) -> list[Point]:
        """Return the places that are banned now, those given up included."""
        return [ban.point for ban in self._bans if ban.until > now or ban.strikes >= MOST_STRIKES]

    def lift(self, now: float) -> bool:
        """End the bans of all places that are not given up; return whether there were any."""
        lifted = [ban for ban in self._bans if ban.until > now and ban.strikes < MOST_STRIKES]
        for ban in lifted:
            ban.until = now
        return bool(lifted)

    @property
    def given_up(self) -> int:
        """How many places are given up."""
        return sum(ban.strikes >= MOST_STRIKES for ban in self._bans)
