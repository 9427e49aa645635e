"""The terminal's table of what changed."""

from __future__ import annotations

from collections.abc import Iterator

from rich import box
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from indoor_explorers.evaluation.analysis.changes.against import Against, Change
from indoor_explorers.evaluation.drawing.formatting import counted

#: Width in characters from which old and new means are shown beside their difference.
WIDE = 110


def against_lines(against: Against, width: int = WIDE) -> Iterator[RenderableType]:
    """Yield the parts of the terminal's output: a table, significant changes first, and what could not be compared."""
    if against.changes:
        yield _table(against, width >= WIDE)
    yield Text(f"{against.shown} of {counted(len(against.changes), 'comparison')} changed significantly")
    for each in against.identities:
        yield Text(f"{each.scenario}, {each.policy}: {each.text}")
    for line in against.apart:
        yield Text(line, "yellow")


def _table(against: Against, wide: bool) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("policy", overflow="fold", min_width=14)
    table.add_column("figure", no_wrap=True)
    for heading in ("old", "new", "new - old", "detectable") if wide else ("new - old",):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("", overflow="fold")
    several, before = len({change.scenario for change in against.changes}) > 1, ""
    for change in against.changes:
        if several and change.scenario != before:
            table.add_row(Text(change.scenario, "bold"))
        before = change.scenario
        names = (Text(change.policy), Text(change.title))
        figures = change.figures if wide else change.figures[2:3]
        table.add_row(*names, *map(Text, figures), Text(change.verdict, _style(change)))
    return table


def _style(change: Change) -> str:
    if not change.shown:
        return "dim"
    return "bold green" if change.better else "bold red"
