"""``playground``: write the page on which a team explores a map that the reader draws."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from indoor_explorers.evaluation.cli.command import Command, make_console, print_line
from indoor_explorers.evaluation.harness.experiment.request import Request
from indoor_explorers.evaluation.harness.options import Option


class PlaygroundOptions(Request):
    """The options of ``playground``."""

    out: Annotated[Path, Option(metavar="FILE.html")] = Path("results/playground.html")
    """The page to write."""


def run_playground(options: PlaygroundOptions, typed: str) -> int:
    """Write the page."""
    from indoor_explorers.env.errors import InputError
    from indoor_explorers.evaluation.studies.playground.page import write_playground

    try:
        write_playground(options.out)
    except OSError as error:
        raise InputError(f"{options.out}: cannot be written: {error.strerror}; choose another --out") from error
    print_line(make_console(), f"Page: {options.out}")
    return 0


PLAYGROUND = Command(
    "playground", "write a page on which a team explores a map that you draw", PlaygroundOptions, run_playground
)
