"""Figures for print as SVG, PNG and PDF: coverage, times, comparison panels and sweeps.

Equal results give equal bytes: no dates, fixed ids. Policies differ by dash and marker as well as by
colour, so the figures can be printed in greyscale.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from indoor_explorers.evaluation.analysis.best_planner import PlannerRow
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.panels.reported_chart import reported_charts
from indoor_explorers.evaluation.drawing.formatting import slug
from indoor_explorers.evaluation.drawing.palette import policy_styles
from indoor_explorers.evaluation.drawing.print_style import print_style, save
from indoor_explorers.evaluation.exports.figures.panel_figures import scenario_figures, sweep_figures
from indoor_explorers.evaluation.exports.figures.planner_figure import planner_figures
from indoor_explorers.evaluation.exports.figures.reported_figure import reported_figure
from indoor_explorers.evaluation.exports.figures.scenario_figures import coverage_figure, times_figure
from indoor_explorers.evaluation.harness.results.results import Results


def write_figures(results: Results, folder: Path, best_planner: Sequence[PlannerRow] = ()) -> list[Path]:
    """Write the figures of the common tasks of every scenario into ``folder`` and return their paths.

    ``best_planner`` are the rows of :func:`~indoor_explorers.evaluation.analysis.best_planner.against_best_planner`.
    """
    results = results.on_common_tasks
    folder.mkdir(parents=True, exist_ok=True)
    styles = policy_styles(results.policies)
    paths = []
    with print_style(), _older_objects_uncollected():
        for number, scenario in enumerate(results.scenarios, 1):
            comparison = Comparison(results, scenario)
            if comparison.groups:
                stem = f"{number:02d}-{slug(scenario)}"
                paths += save(coverage_figure(comparison, styles), folder, f"{stem}-coverage")
                paths += save(times_figure(comparison, styles), folder, f"{stem}-{'-'.join(comparison.level.times)}")
                for name, figure in scenario_figures(comparison, styles):
                    paths += save(figure, folder, f"{stem}-{name}")
                for place, chart in enumerate(reported_charts(comparison, styles), 1):
                    paths += save(reported_figure(chart, comparison.title), folder, f"{stem}-reported-{place}")
        for sheet, figure in enumerate(planner_figures(best_planner), 1):
            paths += save(figure, folder, f"best-planner-{sheet}")
        for name, figure in sweep_figures(results, styles):
            paths += save(figure, folder, name)
    return paths


@contextmanager
def _older_objects_uncollected() -> Iterator[None]:
    """Let the garbage collector skip objects that exist already; scanning them took a sixth of the time."""
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()
