"""``peer dare``: fly policies inside the simulator of another group, run from a clone."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Literal

from indoor_explorers.evaluation.cli.command import Command, make_console, print_line
from indoor_explorers.evaluation.harness.experiment.request import POLICY_NAMES, SEED, Option, Request, read_names


class PeerOptions(Request):
    """The options of ``peer dare``."""

    clone: Annotated[Path, Option(metavar="DIR")]
    """A clone of https://github.com/marmotlab/DARE."""
    python: Annotated[str, Option(metavar="PYTHON")]
    """The interpreter of an environment made by the clone's README; its numpy is before 2."""
    policies: Annotated[tuple[str, ...], POLICY_NAMES] = ("frontier-tour", "expert")
    """Policies to fly; "expert" is DARE's own planner, which ratios are to (default: frontier-tour,expert)."""
    maps: Annotated[tuple[str, ...], Option(metavar="N|NAME,...", read=read_names)] = ()
    """How many of the test maps in the simulator's order, or names such as 12.png,13.png (default: all 100)."""
    adapter: Annotated[Literal["auto", "nodes", "cells"], Option(choices=("auto", "nodes", "cells"))] = "auto"
    """How pilots choose the simulator's nodes: by nodes where their rule can, by cells otherwise (default: auto)."""
    seed: Annotated[int, SEED] = 0
    """Seed of the pilots' and the expert's random numbers (default 0)."""
    out: Annotated[Path | None, Option(metavar="DIR")] = None
    """Keep the flights here, with reported rows for ``report``; flights that are there are not flown again."""


def fly_dare(options: PeerOptions, typed: str) -> int:
    """Fly policies in DARE's simulator, and print their metres and the ratios to its expert's."""
    from indoor_explorers.env.errors import InputError
    from indoor_explorers.env.files import writable
    from indoor_explorers.evaluation.drawing.table import terminal_table
    from indoor_explorers.evaluation.studies.peers.dare import DareSimulator
    from indoor_explorers.evaluation.studies.peers.flights import chosen_by, flights, read_flights, write_flights
    from indoor_explorers.evaluation.studies.peers.results import flight_table, write_rows

    if len(set(options.policies)) < len(options.policies):
        raise InputError("--policies: expected different policies, got one twice; leave it out")
    simulator = DareSimulator(options.clone, options.python)
    names = simulator.maps(options.maps)
    how = {policy: chosen_by(policy, options.adapter) for policy in options.policies}
    held = read_flights(options.out) if options.out else []
    for each in held:
        if each.chosen_by != how.get(each.policy, each.chosen_by):
            raise InputError(f"{options.out}: {each.policy} was flown by {each.chosen_by}; choose another --out")
    console, found = make_console(), {each.key: each for each in held}
    with simulator.process:
        for flight in flights(simulator, options.policies, options.adapter, [(n, options.seed) for n in names], held):
            found[flight.key] = flight
            told = flight.failure or f"{flight.metres:.0f} m, {flight.moves} moves{'' if flight.done else ', not done'}"
            print_line(console, f"{flight.policy} on {flight.map}: {told}", "red" if flight.failure else None)
            if options.out is not None:
                with writable(options.out, "--out"):
                    write_flights(found.values(), options.out)
                    write_rows(list(found.values()), options.out)
    asked = {Path(name).stem for name in names}
    shown = [each for each in found.values() if each.map in asked and each.seed == options.seed]
    table = flight_table([each for each in shown if each.policy in options.policies], options.policies)
    console.print_table(terminal_table(table))
    if options.out is not None:
        print_line(console, f"Flights: {options.out}")
    failed = [each for each in shown if each.failure is not None]
    for each in failed:
        sys.stderr.write(f"indoor-explorers: {each.policy} on {each.map}: {each.failure}\n")
    return 1 if failed else 0


DARE = Command("peer dare", "fly policies in the simulator of DARE, run from a clone of it", PeerOptions, fly_dare)
