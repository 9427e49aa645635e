"""``tune``: search for parameters of a policy."""

from __future__ import annotations

from functools import partial

from indoor_explorers.evaluation.cli.command import Command, make_console, print_line
from indoor_explorers.evaluation.studies.tuning.request import TuneRequest


def run_tune(options: TuneRequest, typed: str) -> int:
    """Tune a policy and print each trial, and last the gain on fresh episodes."""
    from indoor_explorers.evaluation.studies.tuning.running import run_tuning

    run_tuning(options, typed, partial(print_line, make_console()))
    return 0


TUNE = Command(TuneRequest, run_tune)
