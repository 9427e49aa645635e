"""``check``: run the conformance suite on a policy."""

from __future__ import annotations

from contextlib import nullcontext
from typing import Annotated

from indoor_explorers.evaluation.cli.command import Command, debugging, make_console
from indoor_explorers.evaluation.harness.experiment.request import Option, Request


class CheckOptions(Request):
    """The options of ``check``."""

    policy: Annotated[str, Option(metavar="MODULE:CLASS", positional=True)]
    """The policy: MODULE:CLASS, an installed name, or NAME:PATH, with parameters as in 'pso(length=1)'."""


def check(options: CheckOptions, typed: str) -> int:
    """Run the conformance suite on a policy and print the results; the status is 1 if a check fails."""
    from indoor_explorers.env import make_policy, run_checks
    from indoor_explorers.evaluation.cli.check_table import print_findings, print_header
    from indoor_explorers.evaluation.harness.experiment.selection import chosen_policies

    (choice,) = chosen_policies([options.policy], None)
    use, parameters = (choice, {}) if isinstance(choice, str) else (choice["use"], choice["parameters"])
    policy, console = make_policy(use, **parameters), make_console()
    print_header(console, options.policy, policy)
    with console.status("checking") if console.is_terminal else nullcontext():
        findings = list(run_checks(policy))
    print_findings(console, findings)
    failures = [finding.error for finding in findings if finding.error is not None]
    if failures and debugging():
        raise failures[0]
    return 1 if failures else 0


CHECK = Command(CheckOptions, check)
