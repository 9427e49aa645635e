"""How far the maps of one set are from those of another, statistic by statistic."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from indoor_explorers.env import Scenario
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.statistics import STATISTICS, Statistic, map_statistics
from indoor_explorers.env.simulation.spawns import draw_floorplan
from indoor_explorers.evaluation.studies.maps.pockets import fly

#: The statistics of a map, and those of a flight in it.
COMPARED = (
    *STATISTICS,
    Statistic("pocket", "unknown free cells behind a frontier cluster", True),
    Statistic("clusters", "frontier clusters at a time", True),
)


class Sample(NamedTuple):
    """The values of one statistic on all maps of a set, logarithms where sizes are compared by their ratios."""

    values: NDArray[np.float64]
    """(n,) sorted."""
    weights: NDArray[np.float64]
    """(n,) with the sum 1; every map that has values weighs the same."""

    @property
    def spread(self) -> float:
        """The standard deviation."""
        mean = np.average(self.values, weights=self.weights)
        return float(np.sqrt(np.average((self.values - mean) ** 2, weights=self.weights)))

    def quantiles(self, shares: Sequence[float]) -> NDArray[np.float64]:
        """Return (k,) the least values that at least these shares of the weight do not exceed."""
        places = np.searchsorted(np.cumsum(self.weights), np.array(shares) - 1e-9)
        return self.values[np.minimum(places, len(self.values) - 1)]


class MapSet(NamedTuple):
    """The statistics of some maps."""

    name: str
    maps: int
    samples: dict[str, Sample]
    """By name of the statistic; those without any values are left out."""

    @property
    def title(self) -> str:
        """Its name and how many maps it has."""
        return f"{self.name} ({self.maps})"


def maps_of(scenario: Scenario, count: int, seed: int) -> list[Floorplan]:
    """Return all maps of map files, else those of ``count`` seeds from ``seed`` on."""
    seeds = range(seed, seed + count) if scenario.map.generated else (seed,)
    return [draw_floorplan(scenario, each, index) for each in seeds for index in range(scenario.map.count)]


def measured(name: str, plans: Sequence[Floorplan], scenario: Scenario, seed: int) -> MapSet:
    """Return the statistics of some maps, each flown once with the scenario's lidar from a start of its seed."""
    found: dict[str, list[NDArray[np.float64]]] = {kind.name: [] for kind in COMPARED}
    for number, plan in enumerate(plans):
        flight = fly(plan, scenario, seed + number)
        values = map_statistics(plan.main_part)
        values["pocket"], values["clusters"] = flight.pockets, flight.clusters
        for kind in COMPARED:
            found[kind.name].append(values[kind.name])
    samples = {kind.name: sample for kind in COMPARED if (sample := pooled(kind, found[kind.name])) is not None}
    return MapSet(name, len(plans), samples)


def pooled(kind: Statistic, values: Sequence[NDArray[np.float64]]) -> Sample | None:
    """Return the sample of a statistic from its values on each map, None where no map has any."""
    some = [each for each in values if len(each)]
    if not some:
        return None
    together = np.concatenate(some)
    weights = np.concatenate([np.full(len(each), 1.0 / len(each) / len(some)) for each in some])
    order = np.argsort(together, kind="stable")
    scaled = np.log(np.maximum(together[order], 1.0)) if kind.logarithmic else together[order]
    return Sample(scaled, weights[order])


def distance(given: Sample, other: Sample) -> float:
    """Return the Wasserstein distance of two samples in standard deviations of the first; infinite if that is 0."""
    far = stats.wasserstein_distance(given.values, other.values, given.weights, other.weights)
    return float(far / given.spread) if given.spread > 0.0 else float("inf") if far > 0.0 else 0.0


def distances(given: MapSet, other: MapSet) -> Iterator[tuple[Statistic, float]]:
    """Yield the distance of each statistic that both sets have."""
    for kind in COMPARED:
        if kind.name in given.samples and kind.name in other.samples:
            yield kind, distance(given.samples[kind.name], other.samples[kind.name])
