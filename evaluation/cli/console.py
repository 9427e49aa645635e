"""The console of the commands: texts are shown as they are, whoever wrote them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment

#: Characters that a terminal obeys, but for line feeds; each is shown as one that stands for what cannot be shown.
OBEYED = dict.fromkeys((*range(10), *range(11, 32), *range(127, 160)), "\N{REPLACEMENT CHARACTER}")


class PlainConsole(Console):
    """A console without markup, whose terminal obeys no text that it prints."""

    def __init__(self, **options: Any) -> None:
        super().__init__(markup=False, **options)

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """Render something to segments, none of which has a control character that rich did not make."""
        for segment in super().render(renderable, options):
            yield segment if segment.control else Segment(segment.text.translate(OBEYED), segment.style)
