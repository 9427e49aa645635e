"""CSV tables: one row for each episode, and one for each step of each mean curve."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pandas as pd

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.coverage_axes import coverage_at, sampled_steps
from indoor_explorers.evaluation.harness.results.results import Results, write_csv
from indoor_explorers.evaluation.statistics import curve_band

CURVE_COLUMNS = ("scenario", "policy", "step", "mean", "low", "high")
#: Approximate number of steps of a curve; all of them where there are fewer.
POINTS = 600


def write_episodes(results: Results, path: Path) -> None:
    """Write results.csv: one row for each episode with every metric; cells are empty for T_q never reached."""
    write_csv(results.episodes(), path)


def write_curves(results: Results, path: Path) -> None:
    """Write curves.csv: mean team coverage by step with its band; no band where there are too few episodes."""
    write_csv(pd.DataFrame(_curve_rows(results), columns=list(CURVE_COLUMNS)).round(6), path)


def _curve_rows(results: Results) -> Iterator[tuple[str, str, int, float, float, float]]:
    for scenario in results.scenarios:
        comparison = Comparison(results.on_common_tasks, scenario)
        for policy, records in comparison.groups.items():
            steps = sampled_steps(comparison, POINTS)
            band = curve_band(coverage_at(records, steps), maps=comparison.maps(policy))
            for step, *point in zip(steps, *band, strict=True):
                yield scenario, policy, int(step), *point
