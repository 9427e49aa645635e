"""``import``: take rows that others flew into a results folder, as reported policies."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

from indoor_explorers.evaluation.cli.command import Command, make_console, print_line
from indoor_explorers.evaluation.harness.experiment.request import Option, Request


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
    from indoor_explorers.env.files import writable
    from indoor_explorers.evaluation.drawing.formatting import counted
    from indoor_explorers.evaluation.harness.reported.importing import BadRows, imported
    from indoor_explorers.evaluation.harness.reported.rows import FILE, joined, read_reported, write_reported
    from indoor_explorers.evaluation.harness.results.reading import StoreReader

    try:
        policies = imported(options.files, options.columns)
    except BadRows as error:
        for fault in error.faults:
            sys.stderr.write(f"{one_line(fault)}\n")
        raise
    if options.out.exists() and not options.out.is_dir():
        raise InputError(f"{options.out}: expected a folder, got a file; choose another --out")
    new, store = {each.name for each in policies}, options.out / "results.db"
    held = [each for each in read_reported(options.out) if not (options.replace and each.name in new)]
    flown, known = [], _known_scenarios()
    if store.is_file():
        with StoreReader(store) as reader:
            flown, known = list(reader.policies()), known | set(reader.scenarios())
    whole = joined([*held, *policies], flown)
    with writable(options.out, "--out"):
        options.out.mkdir(parents=True, exist_ok=True)
        write_reported(whole, options.out)
    console = make_console()
    for policy in policies:
        for name in policy.scenarios:
            unknown = "" if name in known else "; no preset and no suite has a scenario of this name"
            print_line(console, f"{policy.name} on {name}: {counted(len(policy.on(name)), 'row')}{unknown}")
    print_line(console, f"Reported rows: {options.out / FILE}")
    return 0


def _known_scenarios() -> set[str]:
    """Return the names of the presets and of the scenarios of suites."""
    from indoor_explorers.env import PRESETS
    from indoor_explorers.env.scenarios.suites.catalogue import suites

    return {*PRESETS, *(scenario.name for suite in suites().values() for scenario in suite.scenarios())}


IMPORT = Command(ImportOptions, run_import, "nothing was imported")
