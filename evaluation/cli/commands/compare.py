"""``compare``: fly policies on the same tasks and write a report."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from indoor_explorers.evaluation.cli.command import Command, make_console, print_line
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest, Option

if TYPE_CHECKING:
    from rich.console import Console

    from indoor_explorers.evaluation.cli.console import PlainConsole
    from indoor_explorers.evaluation.harness.experiment.experiment import Experiment
    from indoor_explorers.evaluation.harness.results.results import Results


#: What is printed below the causes of failures.
FINISHED = (
    "failed episodes count as finished; --retry-failed flies them again, and replaces those whose process was killed "
    "or ran out of memory"
)


class CompareOptions(ComparisonRequest):
    """The options of ``compare``."""

    out: Annotated[Path, Option(metavar="DIR")]
    """Folder for the results; an existing one is resumed."""


def run_compare(options: CompareOptions, typed: str) -> int:
    """Fly what is missing and print the headline table."""
    from indoor_explorers.evaluation.analysis.tables.headline_table import headline_table

    console = make_console()
    results = fly_and_report(options, typed, console)
    console.print_table(headline_table(results, console.width))
    print_ratios(results, options.ratio_to, console)
    print_reported(results, console)
    print_notes(results, console)
    print_line(console, f"Report: {options.out / 'report.html'}")
    return print_failures(results, console)


def fly_and_report(options: CompareOptions, typed: str, console: PlainConsole) -> Results:
    """Fly what is missing with a progress bar, write the page and the exports, and return all results."""
    from indoor_explorers.evaluation.cli.progress import ProgressBar
    from indoor_explorers.evaluation.driver import run
    from indoor_explorers.evaluation.harness.experiment.planning import plan
    from indoor_explorers.evaluation.harness.results.coverage_threshold import threshold_of

    experiment = plan(options)
    for note in file_notes(experiment):
        print_line(console, note, "yellow")
    thresholds = {scenario.name: threshold_of(scenario.goal) for scenario in experiment.scenarios}
    with ProgressBar(console, thresholds) as bar:
        return run(experiment, options.out, options, watcher=bar, command=typed)


def file_notes(experiment: Experiment) -> list[str]:
    """Return what the readers of map files suspect or leave out, each line once."""
    sources = [scenario.map for scenario in experiment.scenarios if not scenario.map.generated]
    plans = (source.floorplan(index, 0) for source in sources for index in range(source.count))
    return list(dict.fromkeys(note for plan in plans for note in plan.notes))


def print_ratios(results: Results, asked: Sequence[str] | None, console: PlainConsole) -> None:
    """Print steps as ratios to those of the policies asked for, and minus them; nothing where none are."""
    from indoor_explorers.evaluation.analysis.tables.difference_table import difference_lines
    from indoor_explorers.evaluation.analysis.tables.origin_table import origin_tables
    from indoor_explorers.evaluation.analysis.tables.ratio_table import ratio_lines
    from indoor_explorers.evaluation.drawing.table import terminal_table
    from indoor_explorers.evaluation.harness.results.differences import differences
    from indoor_explorers.evaluation.harness.results.origin_ratios import ratios_by_origin
    from indoor_explorers.evaluation.harness.results.ratios import Ratios

    if asked:
        ratios = Ratios.of(results, asked)
        for part in (*ratio_lines(ratios), *difference_lines(results, differences(results, ratios.to))):
            console.print_table(part)
        for table in origin_tables(ratios_by_origin(ratios)):
            console.print_table(terminal_table(table))


def print_reported(results: Results, console: PlainConsole) -> None:
    """Print the reported policies, those of scenarios that were flown beside the flown ones."""
    from indoor_explorers.evaluation.analysis.tables.reported_table import reported_tables
    from indoor_explorers.evaluation.drawing.table import terminal_table

    for table in reported_tables(results):
        console.print_table(terminal_table(table))


def print_notes(results: Results, console: Console) -> None:
    """Print suite and part, what happened to the stores, and which policies know the maps or the seeds."""
    notes = (*results.suite_notes, *results.notes, *results.retry_notes, *results.map_notes, *results.seed_notes)
    for note in (*notes, *results.plugin_notes):
        print_line(console, note)


def print_failures(results: Results, console: Console) -> int:
    """Print a line for each cause of failed episodes; returns the exit status."""
    from indoor_explorers.evaluation.analysis.failures import failure_lines

    lines = list(failure_lines(results.records))
    for line in [*lines, FINISHED] if lines else ():
        print_line(console, line, "red")
    return 1 if lines else 0


COMPARE = Command(CompareOptions, run_compare)
