"""``import``: take rows that others flew into a results folder, as reported policies."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from indoor_explorers.evaluation.cli.command import Command, make_console, print_line, written
from indoor_explorers.evaluation.harness.experiment.request import Option, Request

if TYPE_CHECKING:
    from indoor_explorers.evaluation.harness.reported.rows import ReportedPolicy


class ImportOptions(Request):
    """The options of ``import``."""

    files: Annotated[tuple[Path, ...], Option(metavar="FILE", several=True, positional=True)]
    """CSV, JSON (a list of objects) or Parquet files with a row for each episode, or for each published mean."""
    out: Annotated[Path, Option(metavar="DIR")]
    """The results folder: a new one, one with reported rows, or one written by compare."""
    columns: Annotated[Path | None, Option(metavar="FILE.toml")] = None
    """What the columns of all files are (default: the TOML file beside each file that has its stem)."""
    replace: Annotated[bool, Option()] = False
    """Drop what the folder holds of the same policies first."""


def run_import(options: ImportOptions, typed: str) -> int:
    """Read all files, and write all of their rows or none."""
    from indoor_explorers.env.errors import InputError, one_line
    from indoor_explorers.evaluation.harness.reported.importing import BadRows, imported
    from indoor_explorers.evaluation.harness.reported.rows import (
        FILE,
        joined,
        read_reported,
        refuse_flown_names,
        write_reported,
    )
    from indoor_explorers.evaluation.harness.results.reading import StoreReader

    try:
        policies = imported(options.files, options.columns)
    except BadRows as error:
        for fault in error.faults:
            sys.stderr.write(f"{one_line(fault)}\n")
        raise
    new = {each.name for each in policies}
    held = [each for each in read_reported(options.out) if not (options.replace and each.name in new)]
    whole, store = joined([*held, *policies]), options.out / "results.db"
    known = set(_known_scenarios())
    if store.is_file():
        with StoreReader(store) as reader:
            refuse_flown_names(whole, reader.policies())
            known |= set(reader.scenarios())
    if options.out.exists() and not options.out.is_dir():
        raise InputError(f"{options.out}: expected a folder, got a file; choose another --out")
    with written(options.out):
        options.out.mkdir(parents=True, exist_ok=True)
        write_reported(whole, options.out)
    for line in _lines(policies, known):
        print_line(make_console(), line)
    print_line(make_console(), f"Reported rows: {options.out / FILE}")
    return 0


def _lines(policies: Iterable[ReportedPolicy], known: set[str]) -> Iterable[str]:
    """Yield a line for each policy and scenario, and one for each scenario of an unknown name."""
    from indoor_explorers.evaluation.drawing.formatting import counted

    names = dict.fromkeys(name for policy in policies for name in policy.scenarios)
    for policy in policies:
        for name in policy.scenarios:
            rows = sum(each.scenario == name for each in policy.episodes)
            what = counted(rows, "row") if rows else "published means"
            yield f"{policy.name} on {name}: {what}, reported by {policy.source.citation}"
    for name in (name for name in names if name not in known):
        yield f"scenario {name!r} is no preset and of no suite: shown beside flown results of a scenario of this name"


def _known_scenarios() -> Iterable[str]:
    """Yield the names of the presets and of the scenarios of suites."""
    from indoor_explorers.env import PRESETS
    from indoor_explorers.env.scenarios.suites.catalogue import suites

    yield from PRESETS
    for suite in suites().values():
        yield from (scenario.name for scenario in suite.scenarios())


IMPORT = Command(
    *("import", "take rows that others flew into a results folder", ImportOptions, run_import, "nothing was imported")
)
