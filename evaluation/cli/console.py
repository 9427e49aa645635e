"""The console that commands print to: it escapes control characters, and does not squeeze tables in a pipe."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from unicodedata import category

from rich.console import Console, ConsoleOptions, RenderableType
from rich.measure import Measurement
from rich.segment import Segment

#: Characters of a line where the output is not a terminal, and the most of a table there.
PLAIN_WIDTH, WIDEST = 120, 10_000
#: Unicode's categories of characters that control a terminal, reorder a line or cannot be encoded.
UNPRINTABLE = ("Cc", "Cf", "Cs", "Zl", "Zp")


class PlainConsole(Console):
    """A console without markup, on which control characters are printed as their escapes."""

    def __init__(self) -> None:
        super().__init__(markup=False, emoji=False)
        if not self.is_terminal:
            self.width = PLAIN_WIDTH

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """Render to segments that hold printable text."""
        for segment in super().render(renderable, options):
            yield segment if segment.control else segment._replace(text=printable(segment.text))

    def print_table(self, table: RenderableType) -> None:
        """Print a table or a text; where the output is not a terminal it is as wide as it needs."""
        if self.is_terminal:
            return self.print(table, highlight=False)
        options = replace(self.options, max_width=WIDEST)
        self.width = max(PLAIN_WIDTH, Measurement.get(self, options, table).maximum)
        self.print(table, highlight=False)
        self.width = PLAIN_WIDTH
        return None


def printable(text: str) -> str:
    """Return a text with the escapes of its control characters in their place, but for line feeds."""
    if text.replace("\n", "").isprintable():
        return text
    return "".join(
        each.encode("unicode_escape").decode() if category(each) in UNPRINTABLE and each != "\n" else each
        for each in text
    )
