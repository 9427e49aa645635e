"""Whether results rest on seeds that a policy's weights were trained, validated or chosen on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from indoor_explorers.env.scenarios.seed_sets import SeedUse, fresh_test_set

#: What seeds of a use were for, after "seeds 1 to 9, ".
SAID = {
    SeedUse.TRAINING: "which its training flew",
    SeedUse.VALIDATION: "on which its weights were validated",
    SeedUse.TRIAL: "which were flown before",
    SeedUse.TEST: "on which it was published before",
    SeedUse.TUNING: "on which former weights or settings were compared",
}


def seen_seeds_line(policies: Mapping[str, Mapping[str, Any]], flown: set[int]) -> str:
    """Return a line that names the policies to which some of the ``flown`` seeds are not new; empty without any.

    ``policies`` holds the facts of each by name.
    """
    found: dict[str, list[str]] = {}
    for name, facts in policies.items():
        for what in _seen(facts, flown):
            found.setdefault(what, []).append(name)
    listed = [f"not new to {', '.join(names)}: {what}" for what, names in found.items()]
    return "; ".join([*listed, f"--seed {fresh_test_set().first} begins a fresh set"]) if listed else ""


def _seen(facts: Mapping[str, Any], flown: set[int]) -> Iterator[str]:
    """Say which of some seeds a policy saw, and for what."""
    for use, ranges in facts.get("seen_seeds", {}).items():
        seen = {seed for first, last in ranges for seed in flown if first <= seed <= last}
        if seen:
            span = f"seeds {min(seen)} to {max(seen)}" if len(seen) > 1 else f"seed {min(seen)}"
            yield f"{span}, {SAID[SeedUse(use)]}"
