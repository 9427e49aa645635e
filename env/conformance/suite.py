"""The conformance suite every policy must pass, the project's own and everybody's plug-in."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

from indoor_explorers.env.conformance.answers import check_actions, check_decisions, check_messages, check_tally
from indoor_explorers.env.conformance.findings import Breach, CannotFly, Finding
from indoor_explorers.env.conformance.knowledge import check_unlinked, check_unseen
from indoor_explorers.env.conformance.latency import report_large_latency, report_latency
from indoor_explorers.env.conformance.sameness import check_independent, check_order, check_pickling, check_repeatable
from indoor_explorers.env.conformance.subject import Subject
from indoor_explorers.env.policy import Policy

#: The checks by name, in the order in which they run; each returns what it found or raises a :class:`Breach`.
CHECKS: dict[str, Callable[[Subject], str]] = {
    "decisions": check_decisions,
    "actions": check_actions,
    "messages": check_messages,
    "tally": check_tally,
    "same seed, same episode": check_repeatable,
    "pickling": check_pickling,
    "pilots share nothing": check_independent,
    "order of the batch": check_order,
    "no hidden knowledge": check_unseen,
    "unlinked teammates": check_unlinked,
    "latency": report_latency,
    "latency, large map": report_large_latency,
}


def run_checks(policy: Policy) -> Iterator[Finding]:
    """Run every check on a policy, also after one has failed, and yield what each found.

    A policy that raises fails the check that met it first; those that meet the same are not run. Nothing stops a
    policy that takes for ever.
    """
    subject = Subject(policy)
    grounded: dict[str, str] = {}
    for name, check in CHECKS.items():
        start = time.perf_counter()
        try:
            text, error = check(subject), None
        except Breach as breach:
            text, error = breach.found, breach
        seconds = time.perf_counter() - start
        cause = grounded.get(text) if isinstance(error, CannotFly) else None
        if cause is not None:
            yield Finding(name, False, f"not run: see {cause}", seconds, error, ran=False)
            continue
        if isinstance(error, CannotFly):
            grounded[text] = name
        yield Finding(name, error is None, text, seconds, error)


def check_policy(policy: Policy) -> dict[str, str]:
    """Fly a policy through the conformance suite; return what each check found.

    Raises:
        PolicyError: the policy breaks its contract; the message names the likely cause.

    """
    report = {}
    for finding in run_checks(policy):
        if finding.error is not None:
            raise finding.error
        report[finding.name] = finding.text
    return report
