"""``peer dare``: fly policies inside the simulator of another group, run from a clone."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from indoor_explorers.evaluation.cli.command import Command, make_console
from indoor_explorers.evaluation.cli.commands.peer_flights import kept_flights, print_flights, refuse_repeated
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
    scan_on_the_way: Annotated[bool, Option()] = False
    """Let the robot scan in every cell that it passes; by DARE's rules it scans at nodes alone."""
    seed: Annotated[int, SEED] = 0
    """Seed of the pilots' and the expert's random numbers (default 0)."""
    out: Annotated[Path | None, Option(metavar="DIR")] = None
    """Keep the flights here, with reported rows for ``report``; flights that are there are not flown again."""


def fly_dare(options: PeerOptions, typed: str) -> int:
    """Fly policies in DARE's simulator, and print their metres and the ratios to its expert's."""
    from indoor_explorers.env.errors import InputError
    from indoor_explorers.evaluation.studies.peers.dare import DareSimulator
    from indoor_explorers.evaluation.studies.peers.flights import FILE, Flight, chosen_by, flights
    from indoor_explorers.evaluation.studies.peers.kept import read_flights, write_flights
    from indoor_explorers.evaluation.studies.peers.results import flight_table, write_rows

    refuse_repeated(options.policies)
    simulator = DareSimulator(options.clone, options.python, scans_on_the_way=options.scan_on_the_way)
    names = simulator.maps(options.maps)
    how = {policy: chosen_by(policy, options.adapter) for policy in options.policies}
    held = read_flights(options.out / FILE, Flight) if options.out else []
    for each in held:
        if each.chosen_by != how.get(each.policy, each.chosen_by):
            raise InputError(f"{options.out}: {each.policy} was flown by {each.chosen_by}; choose another --out")

    def told(flight: Flight) -> str:
        return f"{flight.metres:.0f} m, {flight.moves} moves{'' if flight.done else ', not done'}"

    def write(out: Path, found: list[Flight]) -> None:
        write_flights(out / FILE, Flight, found)
        write_rows(found, out)

    console, tasks = make_console(), [(name, options.seed) for name in names]
    with simulator.process:
        ending = flights(simulator, options.policies, options.adapter, tasks, held)
        found = kept_flights(console, held, ending, told, options.out, write)
    keys = {(Path(name).stem, options.seed, options.scan_on_the_way) for name in names}
    shown = [each for each in found if each.key[1:] in keys]
    table = flight_table([each for each in shown if each.policy in options.policies], options.policies)
    return print_flights(console, table, shown, options.out)


DARE = Command(PeerOptions, fly_dare)
