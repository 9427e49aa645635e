"""A table of figures: built once, then written for the terminal (here), the page, LaTeX and Markdown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from markupsafe import Markup
from rich import box
from rich import table as terminal
from rich.console import OverflowMethod
from rich.text import Text


@dataclass(frozen=True)
class Cell:
    """A figure, or words; empty where there is none."""

    text: str = ""
    value: float | None = None
    """The figure unrounded."""
    detail: str | Markup = ""
    """What stands beside it in small letters: its interval, counts or a drawing."""
    best: bool = False
    """Whether it is significantly better than that of every other policy."""
    bad: bool = False
    shade: int = 0
    """Number of its colour on the page."""
    title: str = ""
    """What the page says where a reader points at it."""
    style: str = ""
    """Colour and weight at the terminal; by default bold for the best, red for bad."""

    @property
    def line(self) -> str:
        """The figure with its detail."""
        return f"{self.text} {self.detail}" if self.detail else self.text


@dataclass(frozen=True)
class Column:
    """A heading, and how what is below it is set: figures stand right and are never broken."""

    title: str
    unit: str = ""
    key: str = ""
    left: bool = False
    overflow: OverflowMethod | None = None
    """How the terminal breaks what is too long, if it may."""
    least: int | None = None
    """Width in characters that the terminal leaves it at least."""
    style: str = ""


def words(title: str, least: int | None = None) -> Column:
    """Return a column of names or sentences, which stand left and are broken wherever their line ends."""
    return Column(title, left=True, overflow="fold", least=least)


class Row(NamedTuple):
    """The cells of one policy; a row without cells is a heading of those below it."""

    name: str
    cells: Sequence[Cell] = ()
    style: str = ""
    """Colour and weight of the name at the terminal."""


@dataclass(frozen=True)
class Table:
    """Rows of figures with the sentences that explain them."""

    columns: Sequence[Column]
    """The first is that of the rows' names."""
    rows: Sequence[Row]
    title: str = ""
    key: str = ""
    """What anchors call it."""
    notes: Sequence[str] = ()


def terminal_table(table: Table, *, sections: bool = False) -> terminal.Table:
    """Return the table for the terminal; with ``sections``, a blank line stands above each heading of rows."""
    drawn = terminal.Table(
        title=table.title or None,
        caption="\n".join(table.notes) or None,
        box=box.SIMPLE_HEAD,
        pad_edge=False,
        title_justify="left",
        title_style="",
        caption_justify="left",
    )
    for column in table.columns:
        drawn.add_column(
            column.title,
            justify="left" if column.left else "right",
            style=column.style,
            overflow=column.overflow or "ellipsis",
            no_wrap=column.overflow is None,
            min_width=column.least,
        )
    for name, cells, style in table.rows:
        if sections and not cells:
            drawn.add_section()
        drawn.add_row(Text(name, style or ("" if cells else "bold")), *map(_shown, cells))
    return drawn


def _shown(cell: Cell) -> Text:
    return Text(cell.line, cell.style or ("bold" if cell.best else "bold red" if cell.bad else ""))
