"""Episodes that failed or ended early, in words and grouped by cause."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.drawing.formatting import EN_DASH
from indoor_explorers.evaluation.harness.episodes.record import Outcome, Record


def failed(records: Sequence[Record]) -> list[Record]:
    """Return the episodes in which the policy failed."""
    return [record for record in records if record.outcome is Outcome.FAILED]


def failed_of(comparison: Comparison, policy: str) -> str:
    """Return in how many of its episodes of a scenario a policy failed, ``3 of 30``; empty for none."""
    records = comparison.groups[policy]
    count = len(failed(records))
    return f"{count} of {len(records)}" if count else ""


def failure_lines(records: Sequence[Record]) -> Iterator[str]:
    """Yield a line for each policy and cause of failed episodes, the most frequent first."""
    flown = Counter(record.policy for record in records)
    for group in by_cause(failed(records)):
        first = group[0]
        yield (
            f"failed: {first.policy} in {len(group)} of {flown[first.policy]} episodes, first on "
            f"{first.task.scenario}, seed {first.task.seed}, step {first.steps}: {first.reason}"
        )


def failed_or_ended(records: Sequence[Record]) -> list[Record]:
    """Return the episodes that ended before goal and budget: failed ones first, then those whose UAVs all ended."""
    return [*failed(records), *(record for record in records if record.outcome is Outcome.ENDED)]


def ending(record: Record) -> str:
    """Say in a few words how an episode ended."""
    words = {
        Outcome.COMPLETE: "goal reached",
        Outcome.BUDGET: "budget spent",
        Outcome.ENDED: "all UAVs ended",
        Outcome.FAILED: "policy failed",
    }[record.outcome]
    return f"{words} {EN_DASH} {record.reason}" if record.reason else words


def by_cause(records: Sequence[Record]) -> list[list[Record]]:
    """Group failed or early ended records by policy and cause, the most frequent first."""
    groups: dict[tuple[str, str], list[Record]] = {}
    for record in records:
        groups.setdefault((record.policy, _cause(record)), []).append(record)
    return sorted(groups.values(), key=lambda group: -len(group))


def _cause(record: Record) -> str:
    """Return the cause of an early end, equal for episodes whose messages differ only in numbers."""
    if record.outcome is Outcome.ENDED:
        return f"{record.outcome}: {', '.join(uav_ends(record))}"
    return f"{record.outcome}: " + re.sub(r"-?\d+(\.\d+)?", "#", record.reason)


def uav_ends(record: Record) -> list[str]:
    """Return the different ways in which the UAVs of an episode ended."""
    return sorted({part.partition(": ")[2] for part in record.reason.split(", ")})
