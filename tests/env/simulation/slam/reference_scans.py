"""What a scan with errors reads, cell by cell, from the rules that the documents state."""

import math
from functools import lru_cache

import numpy as np

from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.randomness import Stream, draw, stream_key
from tests.env.sensing.reference import ancestor_scan, reference_scan

#: Down, left, up, right: as the actions.
DIRECTIONS = ((1, 0), (0, -1), (-1, 0), (0, 1))
#: Log-odds of a reading, and how many of them a certain one is worth.
HIT, PASS, CERTAIN = 0.875, -0.40625, 16
DISTORTION, ERROR, ANGLE = range(3)


def bits(key, counter):
    """64 random bits as a Python integer."""
    return int(draw(np.uint64(key), np.uint64(counter)))


def uniform(key, counter):
    """A random number in [0, 1)."""
    return (bits(key, counter) >> 11) / 2**53


def half_up(number):
    """Round to the nearest whole number."""
    return math.floor(number + 0.5)


@lru_cache(maxsize=20_000)
def visible(model, lidar_range, occupancy, shape, cell):
    """The cells that a lidar without errors sees; ``occupancy`` holds the bytes of a map."""
    see = ancestor_scan if model == "marsexplorer" else reference_scan
    belief = see(np.frombuffer(occupancy, np.uint8).reshape(shape), cell, lidar_range)
    return tuple((int(r), int(c)) for r, c in np.argwhere(belief != UNKNOWN))


class SlowScans:
    """All scans of an episode."""

    def __init__(self, scenario, truth, seed):
        self.scenario, self.truth, self.key = scenario, truth, stream_key(seed, int(Stream.NOISE))

    def first_heading(self, agent):
        return bits(self.key, agent) % 4

    def _stream(self, agent, number, kind):
        return bits(self.key, (number * self.scenario.team + agent) * 3 + kind)

    def distorted(self, agent, number, cell):
        """What the lidar takes for the map: any cell may be taken for the opposite, but for its own."""
        noise, key = self.scenario.noise, self._stream(agent, number, DISTORTION)
        seen = self.truth.copy()
        for place, value in np.ndenumerate(self.truth):
            chance = noise.false_returns if value == FREE else noise.misses
            if uniform(key, place[0] * self.truth.shape[1] + place[1]) < chance:
                seen[place] = OCCUPIED if value == FREE else FREE
        seen[cell] = FREE
        return seen

    def in_view(self, heading, rows, cols):
        """Whether a place that many rows and columns away is a neighbour, or at most half a field of view aside."""
        if abs(rows) <= 1 and abs(cols) <= 1:
            return True
        down, right = DIRECTIONS[heading]
        aside = math.degrees(math.atan2(abs(rows * right - cols * down), rows * down + cols * right))
        return aside <= self.scenario.lidar.field_of_view / 2 + 1e-6

    def read_at(self, agent, number, cell, place):
        """Where an obstacle is read: nearer or farther along its ray. Also whether that is farther."""
        rows, cols = place[0] - cell[0], place[1] - cell[1]
        distance, index = math.sqrt(rows**2 + cols**2), place[0] * self.truth.shape[1] + place[1]
        radius, angle = (uniform(self._stream(agent, number, kind), index) for kind in (ERROR, ANGLE))
        error = math.sqrt(-2 * math.log(1 - radius)) * math.cos(2 * math.pi * angle)
        read = max(1.0, distance + self.scenario.noise.range_std * error)
        return (cell[0] + half_up(rows * read / distance), cell[1] + half_up(cols * read / distance)), read > distance

    def readings(self, agent, number, cell, heading, bump):
        """The log-odds that a scan in ``cell`` gives to each place; ``bump``: action that hit an obstacle, or -1."""
        found = {}

        def note(place, value):
            if all(0 <= k < size for k, size in zip(place, self.truth.shape, strict=True)):
                found[place] = max(value, found.get(place, -math.inf))

        note(cell, CERTAIN * PASS)
        lidar, seen = self.scenario.lidar, self.distorted(agent, number, cell)
        for place in visible(lidar.model, lidar.range, seen.tobytes(), seen.shape, cell):
            if place == cell or not self.in_view(heading, place[0] - cell[0], place[1] - cell[1]):
                continue
            if seen[place] == FREE:
                note(place, PASS)
                continue
            read, farther = self.read_at(agent, number, cell, place)
            if farther and read != place:
                note(place, PASS)
            note(read, HIT)
        if bump >= 0:
            note((cell[0] + DIRECTIONS[bump][0], cell[1] + DIRECTIONS[bump][1]), CERTAIN * HIT)
        return found
