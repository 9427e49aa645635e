"""``report``: rebuild a report, combine several results, or compare new results with old ones."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

from indoor_explorers.evaluation.cli.command import Command, make_console, print_line
from indoor_explorers.evaluation.cli.commands.compare import print_notes, print_ratios, print_reported
from indoor_explorers.evaluation.harness.experiment.request import (
    MARGIN_SHARE,
    PLUGIN_NAMES,
    POLICY_NAMES,
    Option,
    Request,
    read_natural,
    read_thinking,
)


class ReportOptions(Request):
    """The options of ``report``."""

    folders: Annotated[tuple[Path, ...], Option(metavar="DIR", several=True, positional=True)]
    """Folders written by compare, or by import."""
    out: Annotated[Path, Option(metavar="FILE.html")]
    """The page to write."""
    against: Annotated[Path | None, Option(metavar="OLD")] = None
    """Also show what changed since the results in this folder; reported rows alone are shown beside."""
    ratio_to: Annotated[tuple[str, ...] | None, POLICY_NAMES] = None
    """Print steps divided by those of these policies on the same tasks, and minus them. The page always has ratios;
    by default to frontier-nearest, or else the first policy, and to policies that know the map."""
    margin: Annotated[float | None, MARGIN_SHARE] = None
    """Call two policies as good where tests show that neither mean time is this share above the other (default: that of
    compare, 0.05); 0 for no such statement."""
    replays: Annotated[int | None, Option(metavar="N", read=read_natural)] = None
    """Embed replays of N episodes of each scenario (default: as many as keep the page under 10 MB)."""
    explanations: Annotated[float | None, Option(metavar="SECONDS", read=read_thinking)] = None
    """Fly embedded episodes again for which policies thought up to this long together, so that the page explains them
    (default 2, of the episode with which each scenario opens; 0 for none)."""
    metrics: Annotated[tuple[str, ...], PLUGIN_NAMES] = ()
    """Metrics of plug-ins to add: installed names, or module:NAME."""
    panels: Annotated[tuple[str, ...], PLUGIN_NAMES] = ()
    """Panels of plug-ins to add to the page: installed names, or module:function."""
    plugins: Annotated[tuple[str, ...], PLUGIN_NAMES] = ()
    """Lidar and radio models from outside this package that the results name and that may be imported for replays, and
    policies to explain them."""
    exports: Annotated[Path | None, Option(metavar="DIR")] = None
    """Also write summary, tables, figures, experiments and planner-arena.db."""


def run_report(options: ReportOptions, typed: str) -> int:
    """Rebuild a report from one folder, or combine several; print what changed against old results.

    Reported rows alone are printed, without a page.
    """
    from indoor_explorers.env.errors import InputError
    from indoor_explorers.evaluation.analysis.against import against_lines, compare_with
    from indoor_explorers.evaluation.harness.results.combine import combined
    from indoor_explorers.evaluation.harness.results.custom_metrics import with_metrics
    from indoor_explorers.evaluation.harness.results.results import Results
    from indoor_explorers.evaluation.report import write_report

    parts = [Results.load(folder, options.plugins) for folder in options.folders]
    old = None if options.against is None else Results.load(options.against)
    if old is not None and not old.scenarios:  # reported rows alone are no older results of the same policies
        parts, old = [*parts, old], None
    whole, console = combined(parts), make_console()
    if whole.reported and not whole.scenarios:
        print_reported(whole, console)
        print_line(console, "No page: it needs flown results of a scenario beside these rows: report DIR FLOWN --out")
        return 0
    results = with_metrics(whole, options.metrics)
    if options.margin is not None:
        results = replace(results, margin=options.margin)
    against = None if old is None else compare_with(results, old)
    if against is not None and not against.identities:
        raise InputError(
            f"--against {options.against}: expected results of the same tasks, got none in both; "
            + "; ".join(against.apart)
        )
    try:
        write_report(
            results,
            options.out,
            against=against,
            replays=options.replays,
            ratio_to=options.ratio_to,
            panels=options.panels,
            explanations=options.explanations,
        )
        if options.exports is not None:
            from indoor_explorers.evaluation.exports import write_exports

            write_exports(results, options.exports, ratio_to=options.ratio_to)
    except OSError as error:
        where = error.filename or options.out
        raise InputError(f"{where}: cannot be written: {error.strerror}; choose another --out or --exports") from error
    for part in against_lines(against, console.width) if against is not None else ():
        console.print_table(part)
    print_ratios(results, options.ratio_to, console)
    print_reported(results, console)
    print_notes(results, console)
    print_line(console, f"Report: {options.out}")
    return 0


REPORT = Command(ReportOptions, run_report)
