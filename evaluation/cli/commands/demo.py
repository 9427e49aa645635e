"""``demo``: a first comparison and a film of it, in the first minute."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from indoor_explorers.evaluation.cli.command import Command, make_console, print_line
from indoor_explorers.evaluation.harness.experiment.request import Option, Request

#: What is flown: policies that are soon compiled, in a room of the thesis.
POLICIES, SCENARIO, EPISODES, SEED = ("frontier-nearest", "frontier-utility", "pso"), "thesis-team-4", 10, 1_000_000


class DemoOptions(Request):
    """The options of ``demo``."""

    out: Annotated[Path, Option(metavar="DIR")] = Path("results/demo")
    """Folder for the results, the page and the film."""


def run_demo(options: DemoOptions, typed: str) -> int:
    """Compare three policies, film them side by side, and end with a table, the two files and what to try next."""
    from indoor_explorers.evaluation.analysis.tables.headline_table import headline_table
    from indoor_explorers.evaluation.cli.commands.compare import CompareOptions, fly_and_report, print_failures
    from indoor_explorers.evaluation.cli.commands.watch import WatchOptions, run_watch

    console = make_console()
    print_line(console, f"Four UAVs explore {EPISODES} rooms with {', '.join(POLICIES)}", "bold")
    compared = CompareOptions(policies=POLICIES, scenario=SCENARIO, episodes=EPISODES, seed=SEED, out=options.out)
    results = fly_and_report(compared, typed, console)
    film = options.out / "demo.gif"
    run_watch(WatchOptions(policy=POLICIES, scenario=SCENARIO, seed=SEED, save=film), typed)
    console.print_table(headline_table(results, console.width, notes=False))
    print_line(console, "T90, T99: mean steps until 90 % and 99 % are known [95 % interval]; fewer is better.")
    print_line(console, f"Report, with curves and every episode to replay: {options.out / 'report.html'}")
    print_line(console, f"Film of one episode: {film}")
    print_line(console, "Next: indoor-explorers policies | scenarios | compare --help")
    return print_failures(results, console)


DEMO = Command(DemoOptions, run_demo)
