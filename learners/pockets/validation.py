"""Calibration and ranking (AUC) of the estimates on buildings that the network has not seen."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.maps.kinds import kind_of
from indoor_explorers.env.maps.sources import FileMaps
from indoor_explorers.env.scenarios.suites.catalogue import buildings, source_of, suite_of
from indoor_explorers.env.scenarios.suites.suite import Part
from indoor_explorers.learners.pockets.examples import examples_of
from indoor_explorers.planners.toolbox.pockets.estimates import PocketEstimates, estimates_from, load_weights
from indoor_explorers.planners.toolbox.pockets.features import PLAIN, Kind
from indoor_explorers.planners.toolbox.pockets.network import THRESHOLDS, outputs

#: Numbers of cells whose exceedance is judged.
JUDGED = (0, 3, 24)
#: Lidar range, in cells, of the flights over the maps.
LIDAR_RANGE = 10.0


class Judged(NamedTuple):
    """Calibration and ranking of the estimates for a group of maps."""

    group: str
    """A building, source or kind."""
    clusters: int
    """Number of clusters."""
    aucs: tuple[float, ...]
    """For each of ``JUDGED``, the chance that a larger pocket gets the larger probability; nan if all are alike."""
    predicted: tuple[float, ...]
    """Mean probabilities of exceeding each of ``JUDGED``."""
    observed: tuple[float, ...]
    """Shares of clusters that exceed each."""
    entropy: float
    """Mean cross-entropy over all thresholds, in nats."""


def auc(positive: NDArray[np.bool_], scores: NDArray[np.float64]) -> float:
    """Return the chance that a positive case has a larger score than a negative one, ties half; NaN without both.

    ``positive`` (N,) bool marks the positive cases, ``scores`` (N,) are the scores of all.
    """
    from scipy.stats import mannwhitneyu

    if positive.all() or not positive.any():
        return float("nan")
    above = mannwhitneyu(scores[positive], scores[~positive]).statistic
    return float(above / (positive.sum() * (~positive).sum()))


def judged(group: str, examples: Mapping[str, NDArray[Any]], estimates: PocketEstimates) -> Judged:
    """Compare the estimates of K clusters with the true ``sizes`` (K,) of ``examples``."""
    columns = [THRESHOLDS.index(limit) for limit in JUDGED]
    larger = examples["sizes"][:, None] > np.array(THRESHOLDS)
    chance = np.clip(estimates.tails, 1e-6, 1.0 - 1e-6)
    return Judged(
        group,
        len(larger),
        tuple(auc(larger[:, k], estimates.tails[:, k]) for k in columns),
        tuple(float(estimates.tails[:, k].mean()) for k in columns),
        tuple(float(larger[:, k].mean()) for k in columns),
        float(-np.where(larger, np.log(chance), np.log(1.0 - chance)).mean()),
    )


#: The examples of a flight, and the groups of maps that they belong to.
Flown = tuple[tuple[str, ...], Mapping[str, NDArray[Any]]]


def over_files(suites: Sequence[FileMaps]) -> Iterator[Flown]:
    """Fly once over each map of some suites; yield its examples as those of its building, source, kind and of all.

    The source is the repository, the kind that of the floor plan.
    """
    for maps in suites:
        for index in range(maps.count):
            plan = maps.floorplan(index, 0)
            building = buildings().get(plan.digest, plan.name)
            groups = (building, f"source {source_of(maps, index, plan)}", f"kind {kind_of(plan)}", "all")
            yield groups, examples_of(plan, index, LIDAR_RANGE)


def over_levels() -> Iterator[Flown]:
    """Fly once in each building of the validation part of the suite ``levels``; yield the examples, by scenario."""
    suite = suite_of("levels")
    for scenario in suite.scenarios(teams=(1,)):
        for seed in suite.seeds(Part.VALIDATION):
            yield (scenario.name, "all"), examples_of(scenario.map.floorplan(0, seed), seed)


def judge(flights: Iterable[Flown], weights: Path, kind: Kind = PLAIN) -> list[Judged]:
    """Judge the estimates of a weights file for a ``kind`` of maps by the examples of some flights.

    There is a row for each group of each flight's first name, then of the second one, and so on.
    """
    network = load_weights(weights, kind)
    by: dict[tuple[int, str], list[Mapping[str, NDArray[Any]]]] = {}
    for groups, examples in flights:
        for entry in enumerate(groups):
            by.setdefault(entry, []).append(examples)
    found = []
    for (_, group), parts in sorted(by.items(), key=lambda item: item[0][0]):
        joined = {name: np.concatenate([each[name] for each in parts]) for name in parts[0]}
        estimates = estimates_from(outputs(joined["fine"], joined["coarse"], joined["numbers"], network))
        found.append(judged(group, joined, estimates))
    return found


def as_table(rows: list[Judged]) -> str:
    """Return the comparison as a Markdown table."""
    head = [f"{what} > {limit}" for limit in JUDGED for what in ("AUC", "told", "found")]
    lines = [f"| maps | clusters | {' | '.join(head)} | cross-entropy |", "|---" * (len(head) + 3) + "|"]
    for row in rows:
        cells = [f"{each:.2f}" for three in zip(row.aucs, row.predicted, row.observed, strict=True) for each in three]
        lines.append(f"| {row.group} | {row.clusters:,} | {' | '.join(cells)} | {row.entropy:.3f} |")
    return "\n".join(lines) + "\n"
