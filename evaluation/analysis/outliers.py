"""Policies that axis ranges leave out: those that move at random, and those far slower than the best."""

from __future__ import annotations

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.harness.episodes.record import Record

#: What a policy states that it plans for if it moves at random.
NOTHING = "nothing"
#: Multiple of the best mean time from which a policy is far behind.
FAR = 3.0


def far_behind(comparison: Comparison) -> list[str]:
    """Return the policies that axis ranges leave out: random ones, and those above :data:`FAR` times the best mean.

    Empty where that would leave no policy.
    """
    policies = comparison.results.policies
    planned = [name for name in comparison.ranked_policies if policies[name].get("plans_for") != NOTHING]
    if not comparison.groups or not planned:
        return []
    most = FAR * max(1.0, min(comparison.time(name).mean for name in planned))
    return [
        name
        for name in comparison.groups
        if policies[name].get("plans_for") == NOTHING or comparison.time(name).mean > most
    ]


def near_groups(comparison: Comparison) -> dict[str, list[Record]]:
    """Return the records by policy without those :func:`far_behind`."""
    far = far_behind(comparison)
    return {policy: records for policy, records in comparison.groups.items() if policy not in far}
