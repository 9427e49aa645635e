"""Failures and early ends, grouped by policy and cause."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from indoor_explorers.evaluation.analysis.failures import by_cause, ending, uav_ends
from indoor_explorers.evaluation.analysis.panels.replay_links import replay_link
from indoor_explorers.evaluation.drawing.formatting import EN_DASH, percent
from indoor_explorers.evaluation.harness.episodes.record import Outcome, Record

#: Limit of seeds that a row lists.
SEEDS = 8


class Cause(NamedTuple):
    """The episodes of one policy that ended early for one cause."""

    policy: str
    cause: str
    """The message of the first of them."""
    episodes: int
    flown: int
    """All episodes of the policy."""
    coverage: str
    """At their ends, from lowest to highest."""
    seeds: str
    replay: str
    """Link to the replay of the first of them."""


def causes(troubles: Sequence[Record], flown: dict[str, int]) -> list[Cause]:
    """Return a row for each policy and cause, most frequent first; ``flown`` counts the episodes of each policy."""
    return [_cause(records, flown[records[0].policy]) for records in by_cause(troubles)]


def _cause(records: list[Record], flown: int) -> Cause:
    first, policy = records[0], records[0].policy
    ended = first.outcome is Outcome.ENDED
    cause = f"all UAVs ended {EN_DASH} {', '.join(uav_ends(first))}" if ended else ending(first)
    covered = sorted(float(record.curve[-1]) for record in records)
    spread = list(dict.fromkeys(percent(share, 1) for share in (covered[0], covered[-1])))
    seeds = list(dict.fromkeys(str(record.task.seed) for record in records))
    more = f" and {len(seeds) - SEEDS} more" if len(seeds) > SEEDS else ""
    coverage, listed = " to ".join(spread), ", ".join(seeds[:SEEDS]) + more
    return Cause(policy, cause, len(records), flown, coverage, listed, replay_link(policy, first.task))
