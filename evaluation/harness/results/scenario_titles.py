"""Titles of stored scenarios: their names, and the settings that differ from the preset of that name."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

from indoor_explorers.env import PRESETS
from indoor_explorers.evaluation.harness.results.policy_version import flat

#: Settings of a preset that differ and that a title names; more are counted.
NAMED = 3


def scenario_title(name: str, settings: Mapping[str, Any]) -> str:
    """Return the name of a stored scenario with the settings in which it differs from its preset.

    A ``thesis-team-4`` of two UAVs is ``thesis-team-4 team=2``, and a name with swept settings gets the other ones
    too. A scenario that has no preset's name keeps its own, as does a setting that earlier results lack.
    """
    differing = list(_differing(settings, *name.split(" ")))
    more = f" and {len(differing) - NAMED} more settings" if len(differing) > NAMED else ""
    return " ".join([name, *differing[:NAMED]]) + more


def _differing(settings: Mapping[str, Any], preset: str, *swept: str) -> Iterator[str]:
    """Yield ``key=value`` for each setting that differs from the preset and is not in the name."""
    if preset not in PRESETS or not all("=" in word for word in swept):
        return
    usual = dict(flat(PRESETS[preset].for_evaluation().model_dump(mode="json")))
    stored, swept_keys = dict(flat(settings)), {word.partition("=")[0] for word in swept}
    if stored.get("map.source") != usual["map.source"]:
        stored = {key: value for key, value in stored.items() if key == "map.source" or not key.startswith("map.")}
    for key in sorted(usual.keys() & stored.keys() - swept_keys - {"name"}):
        if stored[key] != usual[key]:
            yield f"{key}={_value(stored[key])}"


def _value(value: Any) -> str:
    """Return a value as ``--set`` takes it."""
    if isinstance(value, float):
        return f"{value:g}"
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
