"""Sentences about policies that reach the threshold more or less often than the best-ranked one."""

from __future__ import annotations

from indoor_explorers.evaluation.report.analysis.comparison import Comparison


def success_notes(comparison: Comparison) -> list[str]:
    """Name the policies whose success differs significantly from that of the best-ranked; empty without any."""
    differ = [name for name in comparison.ranked_policies if comparison.success_differs(name)]
    first = comparison.ranked_policies[0] if differ else ""
    return [
        f"Reached {comparison.level.percent} {word} often than {first}, significantly: {', '.join(names)}."
        for word, sign in (("less", -1), ("more", 1))
        if (names := [name for name in differ if sign * (comparison.reached(name) - comparison.reached(first)) > 0])
    ]
