"""A command: its name, its options and its function, and what commands print with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from indoor_explorers.env.errors import debugging as debugging
from indoor_explorers.evaluation.harness.experiment.request import Request

if TYPE_CHECKING:
    from rich.console import Console

    from indoor_explorers.evaluation.cli.console import PlainConsole

#: The message after Ctrl-C, unless a command has its own.
KEPT = "what is finished is kept, and the same command goes on from there"

Options = TypeVar("Options", bound=Request)


@dataclass(frozen=True)
class Command(Generic[Options]):
    """What a subcommand of ``indoor-explorers`` takes and does; its name is in the list of commands."""

    options: type[Options]
    """A request; its fields are the options."""
    run: Callable[[Options, str], int]
    """Takes the options and the typed command, and returns the exit status."""
    interrupted: str = KEPT
    """The message after Ctrl-C."""

    def start(self, given: dict[str, Any], typed: str) -> int:
        """Run with the options that were given; returns the exit status."""
        return self.run(self.options(**given), typed)


def make_console() -> PlainConsole:
    """Return the console that commands print to."""
    from indoor_explorers.evaluation.cli.console import PlainConsole

    return PlainConsole()


def print_line(console: Console, line: str, style: str | None = None) -> None:
    """Print a line as it is: no markup, no colours of numbers, never broken."""
    console.print(line, style=style, highlight=False, markup=False, soft_wrap=True)
