"""Calibration and ranking (AUC) of the estimates on buildings that the network has not seen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.maps.kinds import kind_of
from indoor_explorers.env.maps.sources import FileMaps
from indoor_explorers.env.scenarios.suites.catalogue import buildings, source_of
from indoor_explorers.learners.pockets.examples import examples_of
from indoor_explorers.planners.toolbox.pockets.estimates import PocketEstimates, estimates_from, load_weights
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


def judge(suites: Sequence[FileMaps], weights: Path) -> list[Judged]:
    """Judge the estimates of a weights file, from one flight over each map of some suites.

    The rows are those of each building, of each source (the repository) and of each kind of floor plan, and of all.
    """
    network = load_weights(weights)
    by: tuple[dict[str, list[dict[str, NDArray[Any]]]], ...] = ({}, {}, {}, {})
    for maps in suites:
        for index in range(maps.count):
            plan = maps.floorplan(index, 0)
            examples = examples_of(plan, index, LIDAR_RANGE)
            building = buildings().get(plan.digest, plan.name)
            names = (building, f"source {source_of(maps, index, plan)}", f"kind {kind_of(plan)}", "all")
            for groups, name in zip(by, names, strict=True):
                groups.setdefault(name, []).append(examples)
    found = []
    for group, parts in (entry for groups in by for entry in groups.items()):
        examples = {name: np.concatenate([each[name] for each in parts]) for name in parts[0]}
        estimates = estimates_from(outputs(examples["fine"], examples["coarse"], examples["numbers"], network))
        found.append(judged(group, examples, estimates))
    return found


def as_table(rows: list[Judged]) -> str:
    """Return the comparison as a Markdown table."""
    head = [f"{what} > {limit}" for limit in JUDGED for what in ("AUC", "told", "found")]
    lines = [f"| maps | clusters | {' | '.join(head)} | cross-entropy |", "|---" * (len(head) + 3) + "|"]
    for row in rows:
        cells = [f"{each:.2f}" for three in zip(row.aucs, row.predicted, row.observed, strict=True) for each in three]
        lines.append(f"| {row.group} | {row.clusters:,} | {' | '.join(cells)} | {row.entropy:.3f} |")
    return "\n".join(lines) + "\n"
