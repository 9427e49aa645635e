"""``bench``: measure the speed figures on this machine."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from indoor_explorers.evaluation.cli.command import Command, make_console, print_line
from indoor_explorers.evaluation.harness.experiment.request import Option, Request, read_names


class BenchOptions(Request):
    """The options of ``bench``."""

    json_file: Annotated[Path | None, Option(metavar="FILE", flag="--json")] = None
    """Write the figures as a list of name, value and unit."""
    growth: Annotated[bool, Option()] = False
    """Also measure how speed and decision time change with map size, lidar range and team size."""
    figures: Annotated[Path | None, Option(metavar="DIR")] = None
    """Also draw these as growth.svg/.png and decisions.svg/.png in DIR; implies --growth."""
    all: Annotated[bool, Option()] = False
    """Measure everything, including what takes minutes."""
    only: Annotated[tuple[str, ...], Option(metavar="PATTERN,...", read=read_names)] = ()
    """Measure only the figures whose names match, such as 'world-*-core'."""


def run_bench(options: BenchOptions, typed: str) -> int:
    """Measure the speed figures and print them as they come."""
    from indoor_explorers.evaluation.studies import bench

    console = make_console()
    growing = options.growth or options.figures is not None
    measures = bench.measures(everything=options.all or bool(options.only), growing=growing)
    if options.only:
        measures = bench.chosen(measures, [*options.only, *(["growth-*"] if growing else [])])
    figures = list(bench.measured(measures, console))
    if options.json_file is not None:
        bench.write_json(figures, options.json_file)
    if options.figures is not None:
        for path in bench.write_growth(figures, options.figures):
            print_line(console, f"Figure: {path}")
    return 0


BENCH = Command(BenchOptions, run_bench, "nothing was written")
