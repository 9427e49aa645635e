"""``demo``: a first comparison and a film of it, in the first minute."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from indoor_explorers.evaluation.cli.command import Command, make_console, print_line
from indoor_explorers.evaluation.experiment.request import Request
from indoor_explorers.evaluation.options import Option

#: What is flown: policies that are soon compiled, in a room of the thesis.
POLICIES, SCENARIO, EPISODES, SEED = ("frontier-nearest", "frontier-utility", "pso"), "thesis-team-4", 10, 1_000_000


class DemoOptions(Request):
    """The options of ``demo``."""

    out: Annotated[Path, Option(metavar="DIR")] = Path("results/demo")
    """Folder for the results, the page and the film."""


def run_demo(options: DemoOptions, typed: str) -> int:
    """Compare three policies, film them side by side, and say what to try next."""
    from indoor_explorers.evaluation.cli.commands.compare import CompareOptions, run_compare
    from indoor_explorers.evaluation.cli.commands.watch import WatchOptions, run_watch

    console = make_console()
    print_line(console, f"Four UAVs explore {EPISODES} rooms with {', '.join(POLICIES)}", "bold")
    compared = CompareOptions(
        policies=POLICIES, scenario=SCENARIO, episodes=EPISODES, seed=SEED, out=options.out, ratio_to=POLICIES[:1]
    )
    status = run_compare(compared, typed)
    film = options.out / "demo.gif"
    run_watch(WatchOptions(policy=POLICIES, scenario=SCENARIO, seed=SEED, save=film), typed)
    print_line(console, "")
    print_line(
        console, f"Open {options.out / 'report.html'} for curves, intervals and every episode to replay, and {film}."
    )
    print_line(console, "Next: indoor-explorers policies | scenarios | compare --help")
    return status


DEMO = Command("demo", "a first comparison of three policies, with a page and a film", DemoOptions, run_demo)
