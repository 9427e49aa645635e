"""The tables of the experiment ``levels-kinds``: free voxels and surface known over metres flown, by kind of building.

``python -P -m indoor_explorers.evaluation.site.studies.level_kinds DIR`` prints them, in Markdown, from its results.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import Scenario
from indoor_explorers.evaluation.drawing.formatting import p_value, percent, percent_with_interval, with_interval
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.episodes.resimulate import resimulate
from indoor_explorers.evaluation.harness.episodes.surface import seen_share, surface_of
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.statistics import bootstrap_mean, sign_flip_test

#: The planner over levels, and the same at one height.
LEVELS, ONE_HEIGHT = "frontier-latency", "latency, at one height"
#: Metres flown at which the shares known are told, and shares of the free voxels for which metres are.
METRES, SHARES = (25, 50, 100, 200), (0.9, 0.99)


class Flight(NamedTuple):
    """What an episode of one UAV knew after each of its S steps, from its start on."""

    metres: NDArray[np.float64]
    """(S + 1,) metres flown."""
    free: NDArray[np.float64]
    """(S + 1,) share known of the free voxels that can be reached."""
    surface: NDArray[np.float64]
    """(S + 1,) share known of the surface."""

    @classmethod
    def of(cls, record: Record, scenario: Scenario) -> Flight:
        """Return the flight of a record, simulated again for its surface."""
        worlds = resimulate(record, scenario)
        world = next(worlds)
        mask = surface_of(world, 0)
        seen = [seen_share(world, 0, mask), *(seen_share(each, 0, mask) for each in worlds)]
        return cls(np.asarray(record.distance * (record.floorplan.resolution or 1.0)), record.curve, np.array(seen))

    def at(self, metres: float) -> tuple[float, float]:
        """Return the shares of free voxels and surface that are known after so many metres."""
        step = int(np.searchsorted(self.metres, metres + 1e-9, side="right")) - 1
        return float(self.free[step]), float(self.surface[step])

    def metres_to(self, share: float) -> float:
        """Return the metres flown when a share of the free voxels is first known; infinite if it never is."""
        known = self.free >= share - 1e-9
        return float(self.metres[known.argmax()]) if known.any() else np.inf


#: The flights of each task, by policy.
Flights = dict[str, list[Flight]]


def flights_of(results: Results) -> dict[str, Flights]:
    """Return the flights by scenario and policy, those of each policy by seed."""
    found: dict[str, Flights] = {name: {} for name in results.scenarios}
    for record in sorted(results.records, key=lambda each: each.task.seed):
        flight = Flight.of(record, results.scenario(record.task.scenario))
        found[record.task.scenario].setdefault(record.policy, []).append(flight)
    return found


def answer_row(flights: Flights) -> Iterator[str]:
    """Yield what a flight at one height knows at its end and the metres of that, and the metres over levels.

    Those are the metres until as much of the free voxels is known, and until each of :data:`SHARES` is.
    """
    flat, tall = flights[ONE_HEIGHT], flights[LEVELS]
    ends = [float(each.free[-1]) for each in flat]
    yield percent_with_interval(bootstrap_mean(ends))
    yield percent_with_interval(bootstrap_mean([each.surface[-1] for each in flat]))
    for flown in (flat, tall):
        yield _mean([each.metres_to(end) for each, end in zip(flown, ends, strict=True)], 0)
    for share in SHARES:
        yield _mean([each.metres_to(share) for each in tall], 0)


def metres_row(flights: list[Flight]) -> Iterator[str]:
    """Yield the mean shares of free voxels and surface known after each of :data:`METRES`."""
    for metres in METRES:
        yield " / ".join(percent(mean) for mean in np.mean([each.at(metres) for each in flights], axis=0))


def planner_row(kinds: Iterable[Flights], policy: str) -> Iterator[str]:
    """Yield the mean ratio of a policy's metres to those of the planner over levels in some kinds of buildings.

    It is followed by the p of a sign-flip test, for each of :data:`SHARES`.
    """
    pairs = [pair for each in kinds for pair in zip(each[policy], each[LEVELS], strict=True)]
    for share in SHARES:
        ratios = [one.metres_to(share) / other.metres_to(share) for one, other in pairs]
        yield _mean(ratios, 2)
        yield (
            p_value(sign_flip_test([ratio - 1.0 for ratio in ratios])).removeprefix("= ")
            if np.isfinite(ratios).all()
            else "-"
        )


def _mean(values: list[float], decimals: int) -> str:
    """Format the mean over the buildings with its interval; a dash where a flight never got there."""
    return with_interval(bootstrap_mean(values), decimals) if np.isfinite(values).all() else "-"


def tables(results: Results) -> Iterator[str]:
    """Yield the rows of the three tables: the answer, shares over metres, and planners over all kinds, by lidar."""
    found = flights_of(results)
    for name, flights in found.items():
        yield _row(name, *answer_row(flights))
    for name, flights in found.items():
        for policy in (LEVELS, ONE_HEIGHT):
            yield _row(name, policy, *metres_row(flights[policy]))
    lidars = {name: results.scenario(name).lidar.elevation for name in found}
    for elevation in sorted(set(lidars.values())):
        kinds = [flights for name, flights in found.items() if lidars[name] == elevation]
        for policy in (each for each in kinds[0] if each not in (LEVELS, ONE_HEIGHT)):
            yield _row(f"{elevation:g} degrees", policy, *planner_row(kinds, policy))


def _row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    print(*tables(Results.load(Path(sys.argv[1]))), sep="\n")  # noqa: T201 - a script
