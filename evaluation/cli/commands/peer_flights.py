"""What the commands ``peer dare`` and ``peer ir2`` share: keeping flights as they end, and printing them."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.files import writable
from indoor_explorers.evaluation.cli.command import print_line

if TYPE_CHECKING:
    from indoor_explorers.evaluation.cli.console import PlainConsole
    from indoor_explorers.evaluation.drawing.table import Table
    from indoor_explorers.evaluation.studies.peers.flights import Flight
    from indoor_explorers.evaluation.studies.peers.ir2_flights import TeamFlight

AnyFlight = TypeVar("AnyFlight", "Flight", "TeamFlight")


def refuse_repeated(policies: Sequence[str]) -> None:
    """Refuse a list of policies that names one twice.

    Raises:
        InputError: it does.

    """
    if len(set(policies)) < len(policies):
        raise InputError("--policies: expected different policies, got one twice; leave it out")


def kept_flights(
    console: PlainConsole,
    held: Iterable[AnyFlight],
    ending: Iterable[AnyFlight],
    told: Callable[[AnyFlight], str],
    out: Path | None,
    write: Callable[[Path, list[AnyFlight]], None],
) -> list[AnyFlight]:
    """Print a line for each flight as it ends, and write all to ``out`` each time; return all, with those held."""
    found = {each.key: each for each in held}
    for flight in ending:
        found[flight.key] = flight
        style = "red" if flight.failure else None
        print_line(console, f"{flight.policy} on {flight.map}: {flight.failure or told(flight)}", style)
        if out is not None:
            with writable(out, "--out"):
                write(out, list(found.values()))
    return list(found.values())


def print_flights(console: PlainConsole, table: Table, shown: Iterable[AnyFlight], out: Path | None) -> int:
    """Print the table, where the flights are, and which failed; return the exit status."""
    from indoor_explorers.evaluation.drawing.table import terminal_table

    console.print_table(terminal_table(table))
    if out is not None:
        print_line(console, f"Flights: {out}")
    failed = [each for each in shown if each.failure is not None]
    for each in failed:
        sys.stderr.write(f"indoor-explorers: {each.policy} on {each.map}: {each.failure}\n")
    return 1 if failed else 0
