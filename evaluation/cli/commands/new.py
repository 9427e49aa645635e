"""``new``: make the folder that a plug-in starts from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from indoor_explorers.evaluation.cli.command import Command, make_console, print_line
from indoor_explorers.evaluation.harness.experiment.request import Option, Request

KINDS = ("planner", "learner", "map-reader")


class NewOptions(Request):
    """The options of ``new``."""

    kind: Annotated[str, Option(metavar="|".join(KINDS), choices=KINDS, positional=True)]
    """What to start: a policy, a policy with the training of its weights, or a reader of map files."""
    name: Annotated[str, Option(metavar="NAME", positional=True)]
    """Name of the distribution and of what it plugs in; my-planner has the module my_planner."""
    out: Annotated[Path | None, Option(metavar="DIR")] = None
    """The folder to make (default: NAME)."""


def run_new(options: NewOptions, typed: str) -> int:
    """Make the folder and tell what is in it."""
    from indoor_explorers.evaluation.studies.starters.folder import make_folder

    out, console = options.out or Path(options.name), make_console()
    print_line(console, f"{out}: {', '.join(make_folder(options.kind, options.name, out))}")
    print_line(console, f"Next: the commands of {out / 'README.md'}")
    return 0


NEW = Command(NewOptions, run_new, "nothing was made")
