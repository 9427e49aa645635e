"""``suites``: list the suites, or explain one."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from indoor_explorers.evaluation.cli.command import Command, make_console, print_line
from indoor_explorers.evaluation.harness.experiment.request import DATA_FOLDERS, Option, Request

if TYPE_CHECKING:
    from rich.table import Table

    from indoor_explorers.env.scenarios.suites.suite import Suite

#: Repositories of a suite that the list of all suites names; of more it gives the number.
MOST_NAMED = 3


class SuitesOptions(Request):
    """The options of ``suites``."""

    names: Annotated[tuple[str, ...], Option(metavar="NAME", several=True, positional=True)] = ()
    """Suites to explain (default: list all)."""
    data: DATA_FOLDERS = ()
    """Count the map files found here: clones of their repositories, or folders that have the clones in them."""


def run_suites(options: SuitesOptions, typed: str) -> int:
    """Print a table of all suites, or the scenarios, parts and data of some."""
    from indoor_explorers.env.scenarios.suites.catalogue import suite_of, suites

    console = make_console()
    if not options.names:
        console.print(_overview(suites().values()), highlight=False)
        print_line(console, "indoor-explorers suites NAME explains one; SUITES.md tells how they are divided.")
    for name in options.names:
        suite = suite_of(name)
        print_line(console, f"suite {suite.title}: {suite.about}", "bold")
        for line in _task_lines(suite):
            print_line(console, line)
        console.print(_parts(suite), highlight=False)
        for line in _data_lines(suite, options.data):
            print_line(console, line)
    return 0


def _overview(suites: Iterable[Suite]) -> Table:
    from rich.table import Table

    from indoor_explorers.env.scenarios.suites.suite import Part

    headings = ("suite", "version", "maps to train / validate / test", "data", "what it is")
    table = Table(*headings, box=None, header_style="bold")
    for suite in suites:
        maps = " / ".join(str(suite.map_count(part)) for part in Part)
        data = ", ".join(home.name for home in suite.repositories) or "none"
        if len(suite.repositories) > MOST_NAMED:
            data = f"{len(suite.repositories)} repositories"
        table.add_row(suite.name, str(suite.version), maps, data, suite.about)
    return table


def _task_lines(suite: Suite) -> list[str]:
    return [
        f"Scenarios: {', '.join(scenario.name for scenario in suite.scenarios())}",
        f"Split: {suite.split}",
    ]


def _parts(suite: Suite) -> Table:
    from rich.table import Table

    from indoor_explorers.env.scenarios.suites.suite import Part

    table = Table("part", "maps", "buildings", "starts", "tasks", "seeds", box=None, header_style="bold")
    for part in filter(suite.has, Part):
        seeds, buildings = suite.seeds(part), len(suite.buildings(part))
        counts = (suite.map_count(part), buildings or "-", suite.starts, suite.task_count(part))
        table.add_row(part, *map(str, counts), f"{seeds[0]:,} to {seeds[-1]:,}")
    return table


def _data_lines(suite: Suite, data: tuple[Path, ...]) -> Iterable[str]:
    """Yield a line for each repository: its commit, its licence, and how many files were found."""
    from indoor_explorers.env.scenarios.suites.clones import how_to_fetch, located
    from indoor_explorers.env.scenarios.suites.suite import Part

    if not suite.repositories:
        yield "Data: none, the maps are generated."
    found = [entry for part in Part for entry in located(suite, part, data)]
    for home in suite.repositories:
        mine = [root for owner, _, root in found if owner is home]
        there = sum(root is not None for root in mine)
        counted = f", {there} of {len(mine)} maps found below --data" if data else f", {len(mine)} maps"
        yield f"Data: {home.url}{counted}; licence: {home.licence}"
        yield f"  {how_to_fetch(home)}"


SUITES = Command(SuitesOptions, run_suites)
