"""Training examples: frontier clusters at moments of planners' flights, and the true pockets behind them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.files import written_whole
from indoor_explorers.env.grid.cells import FREE, UNREACHABLE
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.policies.registry import make_policy
from indoor_explorers.env.scenarios.presets import on_files
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.env.simulation.world import World
from indoor_explorers.learners.pockets.maps import GENERATED, TrainingMaps
from indoor_explorers.learners.pockets.tasks import lidar_over_levels
from indoor_explorers.planners.toolbox.frontiers.clusters import Clusters, frontier_clusters, nearest_cells
from indoor_explorers.planners.toolbox.pockets.features import pictures
from indoor_explorers.planners.toolbox.pockets.labels import true_pockets

#: Policies that fly; each flight draws one.
POLICIES = ("frontier-nearest", "frontier", "frontier-latency")
#: Approximate number of snapshots in a flight, and most clusters in a snapshot, on plain maps and over levels, where
#: pictures are five times as large.
SNAPSHOTS, CLUSTERS, LEVEL_CLUSTERS = 36, 12, 6
#: Lidar ranges in cells, and their shares of the flights.
RANGES, SHARES = (10.0, 7.0, 5.0, 14.0, 20.0), (0.6, 0.1, 0.1, 0.1, 0.1)
#: Approximate steps of a flight for each free cell, on plain maps with a lidar range of 10, and over levels.
PLAIN_STEPS, LEVEL_STEPS = 0.35, 0.12
#: Coverage at which a flight ends.
ENOUGH = 0.999


def chosen(clusters: Clusters, numbers: NDArray[np.int64]) -> Clusters:
    """Return some of the clusters, by their ``numbers`` (K,)."""
    parts = [clusters.cells[clusters.ends[k] : clusters.ends[k + 1]] for k in numbers]
    cells = np.concatenate(parts) if parts else clusters.cells[:0]
    return Clusters(cells, np.cumsum([0, *map(len, parts)]))


def examples_of(plan: Floorplan, seed: int, lidar_range: float | None = None) -> dict[str, NDArray[Any]]:
    """Return the K examples of one flight over a map as arrays by name; none if the flight was too short.

    ``fine`` and ``coarse`` (K, layers, SIDE, SIDE) uint8 and ``numbers`` (K, N) are the network's inputs, ``sizes``
    (K,) the free cells behind each cluster, ``depths`` (K,) the steps to the farthest of them, ``real`` (K,) bool
    whether the map is from a file. The lidar, and over levels the start, are drawn at random; ``lidar_range`` in cells
    takes the place of the range that is drawn on plain maps.
    """
    rng, free = np.random.default_rng(seed), np.count_nonzero(plan.truth == FREE)
    asked: dict[str, Any]
    if plan.level_count > 1:
        asked, steps = {"spawn": "random", "budget": None, **lidar_over_levels(plan, rng)}, LEVEL_STEPS * free
    else:
        reach = float(rng.choice(RANGES, p=SHARES)) if lidar_range is None else lidar_range
        asked, steps = {"lidar.range": reach}, PLAIN_STEPS * free * 10.0 / reach
    world = World(on_files(("map",), None).with_settings({**asked, "goal": 1.0}))
    world.begin(0, seed, floorplan=plan)
    policy = make_policy(str(rng.choice(POLICIES)))
    every = max(2, round(steps / SNAPSHOTS))
    found: list[dict[str, NDArray[Any]]] = []
    due = int(rng.integers(1, every + 1))
    for step, _ in enumerate(rollout(world, ask_pilots(policy, make_pilots(policy, world), world)), start=1):
        if step == due:
            found.append(_snapshot(world, plan, rng))
            due += int(rng.integers(every // 2 + 1, every + every // 2 + 1))
        if world.team_coverage[0] >= ENOUGH:
            break
    if not found:
        return {}
    examples = {name: np.concatenate([each[name] for each in found]) for name in found[0]}
    return examples | {"real": np.full(len(examples["sizes"]), plan.name != GENERATED)}


def _snapshot(world: World, plan: Floorplan, rng: np.random.Generator) -> dict[str, NDArray[Any]]:
    """Return the examples of the present moment: some random clusters in reach."""
    view, lidar, rise = world.view(0, 0), world.scenario.lidar, plan.levels.rise
    belief = np.array(view.belief)
    clusters = frontier_clusters(belief, lidar.range, rise)
    field = distance_field(belief, view.cell, rise)
    pockets = true_pockets(belief, plan.truth, field, clusters, rise)
    reached = np.flatnonzero(nearest_cells(field, clusters)[1] < UNREACHABLE)
    some = np.sort(rng.permutation(reached)[: LEVEL_CLUSTERS if rise else CLUSTERS])
    seen = pictures(belief, chosen(clusters, some), lidar.range, rise, lidar.elevation)
    return {
        "fine": seen.fine,
        "coarse": seen.coarse,
        "numbers": seen.numbers,
        "sizes": pockets.sizes[some].astype(np.float32),
        "depths": pockets.depths[some].astype(np.float32),
    }


def write_examples(maps: TrainingMaps, path: Path, seed: int) -> None:
    """Write the examples of one flight to a file, unless that is there."""
    if path.exists():
        return
    found = examples_of(maps.draw(np.random.default_rng([seed, 1])), seed)
    with written_whole(path) as whole, whole.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **found)


def read_examples(paths: list[Path]) -> dict[str, NDArray[Any]]:
    """Return the examples (K, ...) of all files, in their order."""
    parts: dict[str, list[NDArray[Any]]] = {}
    for path in paths:
        with np.load(path) as found:
            for name in found.files:
                parts.setdefault(name, []).append(found[name])
    return {name: np.concatenate(each) for name, each in parts.items()}


def chosen_examples(examples: dict[str, NDArray[Any]], learn_from: str) -> dict[str, NDArray[Any]]:
    """Return the examples (K, ...) of ``real`` maps, of ``generated`` ones, or of ``both``."""
    if learn_from == "both":
        return examples
    chosen = examples["real"] == (learn_from == "real")
    return {name: each[chosen] for name, each in examples.items()}
