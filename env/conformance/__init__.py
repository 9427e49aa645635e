"""The conformance suite: the contract of a policy as checks that name the likely cause of a failure."""

from indoor_explorers.env.conformance.failure_modes import FAILURE_MODES, fly_failure_mode
from indoor_explorers.env.conformance.findings import Finding, Violation, shown
from indoor_explorers.env.conformance.flying import is_privileged
from indoor_explorers.env.conformance.suite import CHECKS, check_policy, failed_check, run_checks

__all__ = [
    "CHECKS",
    "FAILURE_MODES",
    "Finding",
    "Violation",
    "check_policy",
    "failed_check",
    "fly_failure_mode",
    "is_privileged",
    "run_checks",
    "shown",
]
