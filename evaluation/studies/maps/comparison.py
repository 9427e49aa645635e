"""Distances between two sets of maps, statistic by statistic: of the maps, and of a flight on each."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from rich import box
from rich.table import Table
from scipy import stats

from indoor_explorers.env import Scenario, World, make_policy
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.statistics import STATISTICS, Statistic, map_statistics
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.env.simulation.rollout import Uav, ask_pilots, make_pilots, rollout
from indoor_explorers.env.simulation.spawns import draw_floorplan
from indoor_explorers.planners.toolbox.frontiers.clusters import frontier_clusters
from indoor_explorers.planners.toolbox.pockets.labels import true_pockets

#: The policy that flies, and steps from one sample of its frontiers to the next.
POLICY, EVERY = "frontier-nearest", 25


class Frontiers(NamedTuple):
    """Frontier statistics sampled during one flight."""

    pockets: NDArray[np.float64]
    """(K,) unknown free cells behind each frontier cluster of each sample, see
    :func:`~indoor_explorers.planners.toolbox.pockets.labels.true_pockets`."""
    clusters: NDArray[np.float64]
    """(L,) number of frontier clusters of each sample."""


def sampled_frontiers(plan: Floorplan, scenario: Scenario, seed: int) -> Frontiers:
    """Explore a map with one UAV and the scenario's lidar; sample its frontiers every :data:`EVERY` steps."""
    world = World(scenario.with_settings({"team": 1, "spawn": "random", "budget": None}).for_evaluation())
    world.begin(0, seed, floorplan=plan)
    policy = make_policy(POLICY)
    asks = ask_pilots(policy, make_pilots(policy, world), world)
    looks: list[NDArray[np.float64]] = []

    def sample_and_ask(flying: list[Uav]) -> Iterable[tuple[Uav, int]]:
        view = world.view(0, 0)
        if view.step % EVERY == 0:
            clusters = frontier_clusters(view.belief, scenario.lidar.range)
            looks.append(true_pockets(view.belief, plan.truth, distance_field(view.belief, view.cell), clusters).sizes)
        return asks(flying)

    for _ in rollout(world, sample_and_ask):
        pass
    return Frontiers(np.concatenate([np.zeros(0), *looks]), np.array([float(len(look)) for look in looks]))


#: The statistics of a map, and of a flight in it.
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
    """Return all maps of map files, or the generated maps of ``count`` seeds from ``seed`` on."""
    seeds = range(seed, seed + count) if scenario.map.generated else (seed,)
    return [draw_floorplan(scenario, each, index) for each in seeds for index in range(scenario.map.count)]


def measured(name: str, plans: Sequence[Floorplan], scenario: Scenario, seed: int) -> MapSet:
    """Return the statistics of some maps, each flown once with the scenario's lidar from a start of its seed."""
    found: dict[str, list[NDArray[np.float64]]] = {kind.name: [] for kind in COMPARED}
    for number, plan in enumerate(plans):
        flight = sampled_frontiers(plan, scenario, seed + number)
        levels = [map_statistics(floor) for floor in plan.floors()]
        values = {name: np.concatenate([level[name] for level in levels]) for name in levels[0]}
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


#: The quantiles that are shown of the given maps.
SHOWN = (0.1, 0.5, 0.9)


def comparison_table(given: MapSet, others: Sequence[MapSet]) -> Table:
    """Return a line for each statistic: its values on the given maps, and how far each of the other sets is away."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("statistic", no_wrap=True)
    table.add_column(f"{given.title}: 10, 50, 90 %", justify="right", no_wrap=True)
    for other in others:
        table.add_column(other.title, justify="right")
    found = [{kind.name: far for kind, far in distances(given, other)} for other in others]
    for kind in COMPARED:
        values = _values(kind, given.samples.get(kind.name))
        table.add_row(kind.name, values, *(_figure(far.get(kind.name)) for far in found))
    table.add_row("mean", "", *(_figure(float(np.mean(list(far.values()))) if far else None) for far in found))
    return table


def _values(kind: Statistic, sample: Sample | None) -> str:
    if sample is None:
        return ""
    shown = sample.quantiles(SHOWN)
    return ", ".join(f"{value:.0f}" if kind.logarithmic else f"{value:.2f}" for value in _unscaled(kind, shown))


def _unscaled(kind: Statistic, values: np.ndarray) -> list[float]:
    return [float(value) for value in (np.exp(values) if kind.logarithmic else values)]


def _figure(value: float | None) -> str:
    return "" if value is None else f"{value:.2f}"
