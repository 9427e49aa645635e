"""Whether results rest on maps that a policy was trained, validated or tuned on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.scenarios.seed_sets import SeedUse
from indoor_explorers.evaluation.harness.results.seen_seeds import SAID

#: Maps that a line names.
MOST_NAMED = 3


def seen_maps_line(policies: Mapping[str, Mapping[str, Any]], flown: Mapping[str, Floorplan]) -> str:
    """Return a line that names the policies to which some of the ``flown`` maps are not new; empty without any.

    ``policies`` holds the facts of each by name, ``flown`` the maps by their digests.
    """
    found: dict[str, list[str]] = {}
    for name, facts in policies.items():
        for what in _seen(facts, flown):
            found.setdefault(what, []).append(name)
    listed = "; ".join(f"{', '.join(names)}: {what}" for what, names in found.items())
    return f"maps seen before ({listed}): such figures may be optimistic" if listed else ""


def _seen(facts: Mapping[str, Any], flown: Mapping[str, Floorplan]) -> Iterator[str]:
    """Say which of some maps a policy saw, and for what first: trainings often validate on their own maps."""
    left = dict(flown)
    for use, digests in facts.get("seen_maps", {}).items():
        found = [digest for digest, plan in left.items() if digest in digests or plan.layout in digests]
        names = sorted(left.pop(digest).name for digest in found)
        if names:
            listed = ", ".join(names[:MOST_NAMED]) + (", ..." if len(names) > MOST_NAMED else "")
            yield f"{SAID[SeedUse(use)]} on {len(names)} of {len(flown)}, {listed}"
