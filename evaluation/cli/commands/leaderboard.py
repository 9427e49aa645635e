"""``leaderboard``: rank the policies of result folders by scenario, after simulating their episodes again."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from indoor_explorers.evaluation.cli.command import Command, make_console, print_line
from indoor_explorers.evaluation.harness.experiment.request import PLUGIN_NAMES, Option, Request, read_natural

if TYPE_CHECKING:
    from indoor_explorers.evaluation.cli.console import PlainConsole
    from indoor_explorers.evaluation.harness.results.results import Results
    from indoor_explorers.evaluation.studies.leaderboard.board import Board

#: Mismatching episodes that an error names.
NAMED = 3


class LeaderboardOptions(Request):
    """The options of ``leaderboard``."""

    folders: Annotated[tuple[Path, ...], Option(metavar="DIR", several=True, positional=True)]
    """Folders written by compare, of suites or of other tasks."""
    fly: Annotated[int, Option(metavar="N", read=read_natural)] = 0
    """Also make each policy, which must be the one stored, and let it fly N of its episodes of each scenario again,
    which must give the same actions. Those from outside this package fly in processes of their own."""
    plugins: Annotated[tuple[str, ...], PLUGIN_NAMES] = ()
    """Policies, map generators, lidar and radio models from outside this package that the results name and that may be
    imported, each spelt as there."""
    out: Annotated[Path | None, Option(metavar="FILE.md")] = None
    """Also write the tables as a Markdown page."""


def run_leaderboard(options: LeaderboardOptions, typed: str) -> int:
    """Verify the results and print a table for each scenario."""
    from indoor_explorers.env.files import writable, written_whole
    from indoor_explorers.evaluation.harness.results.results import Results
    from indoor_explorers.evaluation.studies.leaderboard.board import boards
    from indoor_explorers.evaluation.studies.leaderboard.drawing import legend, markdown_page

    console = make_console()
    parts = [(str(folder), Results.load(folder, options.plugins)) for folder in options.folders]
    found = boards(parts, options.fly)
    with console.status("simulating the episodes again"):
        for folder, results in parts:
            _refuse_mismatches(folder, results, options.fly)
    for board in found:
        _print(board, console)
    print_line(console, " ".join(legend(options.fly)))
    if options.out is not None:
        with writable(options.out, "--out"), written_whole(options.out) as partial:
            partial.write_text(markdown_page(found), "utf-8")
        print_line(console, f"Page: {options.out}")
    return 0


def _refuse_mismatches(folder: str, results: Results, count: int) -> None:
    """Refuse results that the world, or the policy, does not give again."""
    from indoor_explorers.env.errors import RunError
    from indoor_explorers.evaluation.studies.leaderboard.verifying import (
        flown_differently,
        made_again,
        mismatches,
        other_policies,
    )

    faults = list(mismatches(results))
    if count and not faults:
        made = made_again(results)
        if others := other_policies(results, made):
            raise RunError(f"{folder}: {'; '.join(others[:NAMED])}; fly them again with this version of the software")
        faults = list(flown_differently(results, count, made))
    if faults:
        more = f", and {len(faults) - NAMED} more" if len(faults) > NAMED else ""
        raise RunError(
            f"{folder}: {len(faults)} of {len(results.records)} episodes are not as stored: "
            f"{'; '.join(faults[:NAMED])}{more}; fly them again with this version of the software"
        )


def _print(board: Board, console: PlainConsole) -> None:
    from indoor_explorers.evaluation.analysis.tables.policy_names import footnotes
    from indoor_explorers.evaluation.drawing.table import terminal_table
    from indoor_explorers.evaluation.studies.leaderboard.drawing import board_tables, reported_lines

    print_line(console, board.title, "bold")
    for table in board_tables(board):
        console.print_table(terminal_table(table))
    notes: Iterable[str] = footnotes(board.results, list(board.results.policies), times=False)
    for note in (*notes, *board.left_out, *board.results.map_notes, *reported_lines(board)):
        print_line(console, note)


LEADERBOARD = Command(LeaderboardOptions, run_leaderboard)
