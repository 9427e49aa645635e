"""``peer ir2``: fly teams inside the simulator of IR2, run from a clone."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from indoor_explorers.evaluation.cli.command import Command, make_console
from indoor_explorers.evaluation.cli.commands.peer_flights import kept_flights, print_flights, refuse_repeated
from indoor_explorers.evaluation.harness.experiment.request import POLICY_NAMES, Option, Request, read_names


class TeamPeerOptions(Request):
    """The options of ``peer ir2``."""

    clone: Annotated[Path, Option(metavar="DIR")]
    """A clone of https://github.com/marmotlab/IR2."""
    python: Annotated[str, Option(metavar="PYTHON")]
    """The interpreter of an environment made by the clone's README, with numpy before version 2."""
    policies: Annotated[tuple[str, ...], POLICY_NAMES] = ("frontier",)
    """Policies to fly (default: frontier)."""
    tasks: Annotated[Literal["hybrid", "corridor", "complex"], Option(choices=("hybrid", "corridor", "complex"))] = (
        "hybrid"
    )
    """The test set: four robots in hybrid and corridor, five in complex (default: hybrid)."""
    maps: Annotated[tuple[str, ...], Option(metavar="N|NAME,...", read=read_names)] = ()
    """How many maps of the set in the simulator's order, or names such as 99.png,98.png (default: its 100 tasks)."""
    mend_maps: Annotated[bool, Option()] = False
    """Give every robot a map of its own: in the simulator as it is, robots write into the maps of others after the end
    of a contact."""
    against: Annotated[tuple[Path, ...], Option(metavar="DIR", several=True)] = ()
    """Folders with imported rows of these tasks, such as flights of IR2's own weights, for ratios map by map."""
    out: Annotated[Path | None, Option(metavar="DIR")] = None
    """Keep the flights here, with reported rows for ``report``; flights that are there are not flown again."""


def fly_ir2(options: TeamPeerOptions, typed: str) -> int:
    """Fly policies in IR2's simulator, and print their steps, their longest paths and ratios to imported rows."""
    from indoor_explorers.env.errors import InputError
    from indoor_explorers.evaluation.harness.reported.rows import joined, read_reported
    from indoor_explorers.evaluation.studies.peers.ir2 import Ir2Simulator
    from indoor_explorers.evaluation.studies.peers.ir2_flights import FILE, TeamFlight, flights
    from indoor_explorers.evaluation.studies.peers.ir2_results import flight_table, scenario_of, write_rows
    from indoor_explorers.evaluation.studies.peers.kept import read_flights, write_flights

    refuse_repeated(options.policies)
    simulator = Ir2Simulator(options.clone, options.python, mended=options.mend_maps)
    tasks = simulator.tasks(options.tasks, options.maps)
    others = joined(each for folder in options.against for each in read_reported(folder))
    others = tuple(each for each in others if each.on(scenario_of(options.tasks)))
    if options.against and not others:
        raise InputError(f"--against: expected imported rows of scenario {scenario_of(options.tasks)}, found none")
    console, held = make_console(), read_flights(options.out / FILE, TeamFlight) if options.out else []

    def told(flight: TeamFlight) -> str:
        return f"{flight.steps} steps, {flight.pixels:.0f} px{'' if flight.done else ', not done'}"

    def write(out: Path, found: list[TeamFlight]) -> None:
        write_flights(out / FILE, TeamFlight, found)
        write_rows(found, out)

    with simulator.process:
        ending = flights(simulator, options.policies, tasks, held)
        found = kept_flights(console, held, ending, told, options.out, write)
    keys = {(options.tasks, Path(task.map).stem, options.mend_maps) for task in tasks}
    shown = [each for each in found if each.key[1:] in keys and each.policy in options.policies]
    return print_flights(console, flight_table(shown, options.policies, options.tasks, others), shown, options.out)


IR2 = Command(TeamPeerOptions, fly_ir2)
