"""The conformance suite that every policy must pass: the project's own and plug-ins."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator

from indoor_explorers.env.conformance.determinism import (
    check_explanations,
    check_independent,
    check_order,
    check_pickling,
    check_repeatable,
)
from indoor_explorers.env.conformance.failure_modes import check_failure_modes
from indoor_explorers.env.conformance.findings import CannotFly, Differs, Finding, Violation, Warned
from indoor_explorers.env.conformance.harness import Harness
from indoor_explorers.env.conformance.information_leaks import (
    check_generator,
    check_seed,
    check_unlinked,
    check_unseen,
)
from indoor_explorers.env.conformance.latency import report_large_latency, report_latency
from indoor_explorers.env.conformance.levels import check_levels
from indoor_explorers.env.policies.policy import Policy
from indoor_explorers.env.policies.view import MESSAGE_LIMIT


def check_decisions(harness: Harness) -> str:
    """Demand that the policy decides at every step, raises nothing, and leaves views and briefings alone."""
    decisions = sum(len(trace.seconds) for trace in harness.alone)
    _demand(harness, "decisions")
    return f"{decisions} of one UAV and of four; nothing raised, views and briefing left alone"


def check_actions(harness: Harness) -> str:
    """Demand ints from 0 to 4, and count those that lead into a wall or off the map."""
    _demand(harness, "actions")
    into_walls = sum(trace.into_walls for trace in harness.alone)
    return f"all are ints from 0 to 4, {into_walls} of them into a wall or off the map"


def check_messages(harness: Harness) -> str:
    """Demand None or a few finite numbers."""
    _demand(harness, "messages")
    said = [choice.message for trace in harness.alone for step in trace.steps for choice in step.values()]
    longest = max((len(message) for message in said if message is not None), default=None)
    return "none said" if longest is None else f"finite numbers, at most {longest} in one ({MESSAGE_LIMIT} may be)"


def check_tally(harness: Harness) -> str:
    """Demand a dict of finite numbers after an episode."""
    _demand(harness, "tally")
    return "a dict of finite numbers, or nothing to tell"


def _demand(harness: Harness, kind: str) -> None:
    """Raise the first violation of a kind."""
    if (violation := harness.violation(kind)) is not None:
        raise violation


REPEATABLE, LARGE = "same seed, same episode", "latency, large map"
#: The checks by name, in the order in which they run; each returns what it found or raises a :class:`Violation`.
CHECKS: dict[str, Callable[[Harness], str]] = {
    "decisions": check_decisions,
    "actions": check_actions,
    "messages": check_messages,
    "tally": check_tally,
    REPEATABLE: check_repeatable,
    "pickling": check_pickling,
    "explanations": check_explanations,
    "pilots share nothing": check_independent,
    "order of the batch": check_order,
    "no hidden knowledge": check_unseen,
    "map of the seed": check_seed,
    "map generator": check_generator,
    "unlinked teammates": check_unlinked,
    "failure modes": check_failure_modes,
    "several levels": check_levels,
    "latency": report_latency,
    LARGE: report_large_latency,
}
#: The checks for forbidden knowledge, after the checks that they depend on.
KNOWLEDGE = (
    *(REPEATABLE, "pilots share nothing"),
    *("no hidden knowledge", "map of the seed", "map generator", "unlinked teammates"),
)


def run_checks(policy: Policy, names: Iterable[str] = CHECKS) -> Iterator[Finding]:
    """Run the named checks on a policy, also after a failed one, and yield the finding of each.

    A finding that repeats an earlier error, or a difference of a policy that is not repeatable, refers to the earlier
    finding. There is no time limit.
    """
    harness = Harness(policy)
    earlier: dict[str, Finding] = {}
    for name in names:
        start = time.perf_counter()
        try:
            text, error = CHECKS[name](harness), None
        except Violation as violation:
            text, error = violation.found, violation
        seconds = time.perf_counter() - start
        finding = Finding(name, error is None, text, seconds, error, warned=isinstance(text, Warned))
        earlier[name] = finding
        yield _explained(finding, earlier)


def _explained(finding: Finding, earlier: dict[str, Finding]) -> Finding:
    """Refer to an earlier finding that explains this one."""
    first = next(name for name, other in earlier.items() if other.text == finding.text)
    if isinstance(finding.error, CannotFly) and first != finding.name:
        return finding._replace(text=f"not run: see {first}", conclusive=False)
    if isinstance(finding.error, Differs) and finding.name != REPEATABLE and not earlier[REPEATABLE].passed:
        return finding._replace(text=f"cannot be told: see {REPEATABLE}", conclusive=False)
    if isinstance(finding.error, CannotFly) and finding.name == LARGE:
        text = f"cannot be told, as {finding.text}; if it flies maps of one size alone, set its map_shape"
        return finding._replace(text=text, error=None, conclusive=False)
    return finding


def failed_check(policy: Policy) -> str:
    """Return the first of the checks for hidden knowledge that a policy fails, and how to fix it; empty for none.

    The result is empty for a policy that cannot be flown.
    """
    for finding in run_checks(policy, KNOWLEDGE):
        if isinstance(finding.error, Differs):
            return f"{finding.name}: {finding.text}; to fix it, {finding.fix}"
    return ""


def check_policy(policy: Policy) -> dict[str, str]:
    """Fly a policy through the conformance suite; return the findings by check.

    Raises:
        PolicyError: the policy breaks its contract; the message names the likely cause.

    """
    report = {}
    for finding in run_checks(policy):
        if finding.error is not None:
            raise finding.error
        report[finding.name] = finding.text
    return report
