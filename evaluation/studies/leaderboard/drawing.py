"""Leaderboards as tables of the terminal and as a Markdown page."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from dataclasses import replace

from indoor_explorers.env.errors import one_line
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.reported import MARK, reported_on
from indoor_explorers.evaluation.analysis.tables.policy_cells import result_cells
from indoor_explorers.evaluation.analysis.tables.policy_names import footnotes, marked
from indoor_explorers.evaluation.analysis.tables.ratio_table import bounded
from indoor_explorers.evaluation.analysis.tables.reported_table import (
    has_figure,
    reported_cells,
    reported_table,
)
from indoor_explorers.evaluation.drawing.formatting import (
    counted,
    decimals_for,
    fixed,
    interval,
)
from indoor_explorers.evaluation.drawing.table import Cell, Column, Row, Table
from indoor_explorers.evaluation.exports.markdown import escaped, line
from indoor_explorers.evaluation.statistics import CONFIDENCE
from indoor_explorers.evaluation.studies.leaderboard.board import Board, BoardRow

#: The meaning of the columns, and the limits of the verification.
LEGEND = (
    "Rank: 1 + the number of policies that are significantly better at the last threshold, with = where it is shared.",
    f"Times where both finish are compared by a sign-flip test of all pairs at once, p at most {1 - CONFIDENCE:.2f}; "
    "maps of a building are flipped together.",
    "A policy that finishes fewer tasks is not better, one that finishes significantly more is.",
    "Policies that know the map are not ranked.",
    "Times are mean steps [95 % interval]; an episode that never gets there counts as its budget.",
    "Every episode was simulated again from its map, seed and actions.",
)
NOT_FLOWN = "Not flown again (--fly): what policies are and what they know is as their folders say."
#: Steps from which on times have no decimals.
MANY = 100.0
#: Characters of a command, and of a cell at the terminal.
LONGEST_COMMAND, LONGEST_CELL = 10_000, 150


def legend(fly: int) -> tuple[str, ...]:
    """Return sentences on the columns, and on whether policies flew ``fly`` of their episodes again."""
    again = (
        f"Policies were made again, and flew {counted(fly, 'episode')} of each scenario again with the same actions.",
        "Policies that were not are named with the tables.",
    )
    return (*LEGEND, *again) if fly else (*LEGEND, NOT_FLOWN)


def board_tables(board: Board, *, page: bool = False) -> list[Table]:
    """Return a table for each scenario of a leaderboard, for the terminal, or with all that a page has room for.

    Tables of reported policies beside the flown ones come last.
    """
    beside = [reported_table(figures) for comparison in board.comparisons for figures in reported_on(comparison)]
    tables = [_table(board, comparison, page) for comparison in board.comparisons]
    return tables + [replace(table, notes=()) for table in beside]


def reported_lines(board: Board) -> list[str]:
    """Return a line for each reported policy of each scenario."""
    return [figures.note for comparison in board.comparisons for figures in reported_on(comparison)]


def _table(board: Board, comparison: Comparison, page: bool) -> Table:
    times, tasks = comparison.level.times, len(next(iter(comparison.groups.values())))
    titles = [metric.upper() for metric in times]
    columns = [Column("rank"), Column("policy", left=True, overflow="ellipsis"), *map(Column, titles)]
    columns += map(Column, (f"{titles[-1]} / nearest", comparison.level.percent, "AUC"))
    several = page and len(board.flown) > 1
    columns += [Column("flown at")] if several else []
    rows = []
    for row in board.rows(comparison):
        cells = _cells(comparison, row, times) + ([Cell(row.origin.flown)] if several else [])
        rank = row.rank.text if row.rank else ""
        rows.append(Row(rank, cells if page else [Cell(one_line(cell.line, LONGEST_CELL)) for cell in cells]))
    for figures in reported_on(comparison):
        *steps, reached, _, auc, _ = reported_cells(figures, times, _decimals)
        if has_figure([*steps, reached, auc]):
            cells = [Cell(figures.name), *steps, Cell(), Cell(reached.text), Cell(auc.text)]
            rows.append(Row(MARK, cells + [Cell()] * several))
    return Table(columns, rows, f"{comparison.title}: {counted(tasks, 'task')} on {comparison.maps_flown}")


def _cells(comparison: Comparison, row: BoardRow, times: Sequence[str]) -> list[Cell]:
    *steps, reached, _, auc, _ = result_cells(comparison, row.policy, times, {}, _decimals)
    name = Cell(marked(comparison.results, row.policy))
    return [name, *steps, _ratio(row), Cell(reached.text), Cell(auc.text)]


def _decimals(steps: float) -> int:
    return decimals_for(steps) if steps < MANY else 0


def _ratio(row: BoardRow) -> Cell:
    if row.to_baseline is None:
        return Cell()
    ratio = row.to_baseline.ratio.of_tasks
    return Cell(bounded(fixed(ratio.mean, 2), row.to_baseline.censoring.bound), detail=interval(ratio, 2))


def markdown_page(boards: Sequence[Board]) -> str:
    """Return the leaderboards as a Markdown page, with the commands that flew them."""
    return "\n".join(_page(boards))


def _page(boards: Sequence[Board]) -> Iterator[str]:
    title = "Leaderboards" if len(boards) > 1 else f"Leaderboard: {escaped(boards[0].title)}"
    yield from (
        f"# {title}",
        "",
        "This page ranks policies by scenario, as `indoor-explorers leaderboard` writes it.",
        "",
        *legend(boards[0].fly),
        "",
    )
    for board in boards:
        if len(boards) > 1:
            yield from (f"## {escaped(board.title)}", "")
        if board.about:
            yield from (f"{escaped(board.about)}.".replace("..", "."), "")
        for table in board_tables(board, page=True):
            yield from (f"{'###' if len(boards) > 1 else '##'} {escaped(table.title)}", "")
            yield from (line(column.title for column in table.columns), line("---" for _ in table.columns))
            for rank, cells, _ in table.rows:
                yield line(_unbroken(escaped(text)) for text in (rank, *(cell.line for cell in cells)))
            yield ""
        notes = [*footnotes(board.results, list(board.results.policies), times=False), *board.left_out]
        yield from (f"{escaped(note)}\n" for note in (*notes, *board.results.map_notes, *reported_lines(board)))
        origins = list(dict.fromkeys(board.origins.values()))
        commands = dict.fromkeys(_portable(each) for origin in origins for each in origin.commands if each)
        machines = dict.fromkeys(each for origin in origins for each in origin.machines)
        when = f" at {board.flown[0]}" if len(board.flown) == 1 else ""
        yield from (
            f"Flown on {escaped('; '.join(machines))}{when} with",
            "",
            *(f"    {each}" for each in commands),
            "",
        )


def _portable(command: str) -> str:
    """Return a command on one line without the folders of the machine on which it was typed."""
    try:
        words = shlex.split(command)
    except ValueError:  # its runs may say anything
        return one_line(command, LONGEST_COMMAND)
    places = [k for k, word in enumerate(words[:-1], 1) if word in ("--data", "--out")]
    return one_line(shlex.join("DIR" if k in places else word for k, word in enumerate(words)), LONGEST_COMMAND)


def _unbroken(text: str) -> str:
    return text.replace(" ", "\N{NO-BREAK SPACE}")
