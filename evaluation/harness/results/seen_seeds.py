"""Whether results rest on seeds that a policy's weights were trained, validated or chosen on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from indoor_explorers.env.scenarios.seed_sets import SeedUse, fresh_test_set

#: What a policy was when it saw seeds of a use, before "on seeds 1 to 9".
SAID = {
    SeedUse.TRAINING: "trained",
    SeedUse.VALIDATION: "validated",
    SeedUse.TRIAL: "tried out",
    SeedUse.TEST: "published before",
    SeedUse.TUNING: "developed",
}


def seen_seeds_line(policies: Mapping[str, Mapping[str, Any]], flown: set[int]) -> str:
    """Return a line that names the policies to which some of the ``flown`` seeds are not new; empty without any.

    ``policies`` holds the facts of each by name.
    """
    found: dict[str, list[str]] = {}
    for name, facts in policies.items():
        for what in _seen(facts, flown):
            found.setdefault(what, []).append(name)
    listed = "; ".join(f"{', '.join(names)}: {what}" for what, names in found.items())
    fresh = f"such figures may be optimistic; for unseen seeds: --seed {fresh_test_set().first}"
    return f"seeds seen before ({listed}): {fresh}" if listed else ""


def _seen(facts: Mapping[str, Any], flown: set[int]) -> Iterator[str]:
    """Say which of some seeds a policy saw, and for what."""
    for use, ranges in facts.get("seen_seeds", {}).items():
        seen = {seed for first, last in ranges for seed in flown if first <= seed <= last}
        if seen:
            span = f"seeds {min(seen)} to {max(seen)}" if len(seen) > 1 else f"seed {min(seen)}"
            yield f"{SAID[SeedUse(use)]} on {span}"
