"""``playground``: write the page on which a team explores a map that the reader draws."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from indoor_explorers.evaluation.cli.command import Command, make_console, print_line
from indoor_explorers.evaluation.harness.experiment.request import Option, Request


class PlaygroundOptions(Request):
    """The options of ``playground``."""

    out: Annotated[Path, Option(metavar="FILE.html")] = Path("results/playground.html")
    """The page to write."""


def run_playground(options: PlaygroundOptions, typed: str) -> int:
    """Write the page."""
    from indoor_explorers.env.files import writable
    from indoor_explorers.evaluation.studies.playground.page import write_playground

    with writable(options.out, "--out"):
        write_playground(options.out)
    print_line(make_console(), f"Page: {options.out}")
    return 0


PLAYGROUND = Command(PlaygroundOptions, run_playground)
