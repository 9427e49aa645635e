"""Texts about a scenario: a line about its task, its denominator, and the meaning of every setting."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any, get_args

from pydantic import BaseModel

from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.evaluation.drawing.formatting import counted
from indoor_explorers.evaluation.harness.results.policy_version import flat

#: The denominator of coverage in words, by the scenario's setting.
DENOMINATORS = {
    "reachable": "share of the free cells reachable from the spawns",
    "map": "share of all cells of the map",
}


def denominator(settings: Mapping[str, Any]) -> str:
    """Return what coverage is a share of in this scenario."""
    return DENOMINATORS[settings.get("denominator", "reachable")]


def summary_line(settings: Mapping[str, Any], budgets: Sequence[int], shapes: Sequence[tuple[int, ...]]) -> list[str]:
    """Describe a scenario in a few short phrases; ``shapes`` are (H, W), or (L, H, W) of several levels."""
    lidar, radio = settings["lidar"], settings.get("radio", {})
    phrases = [_span([_size(*shape) for shape in shapes], "cells")]
    phrases.append(counted(settings["team"], "UAV"))
    phrases.append(f"lidar {lidar['range']:g} cells")
    if settings["team"] > 1:
        reach = "" if radio.get("model", "none") in ("none", "unlimited") else f" {radio['range']:g} cells"
        loss = f", {radio['loss']:.0%} of contacts lost" if radio.get("loss") else ""
        phrases.append(f"radio {radio.get('model', 'none')}{reach}{loss}")
    phrases.append(_span([str(budget) for budget in budgets], "steps at most"))
    phrases.append(
        "a collision ends the UAV" if settings.get("on_collision") == "end" else "a collision costs the step"
    )
    return [phrase for phrase in phrases if phrase]


def _size(*sides: int) -> str:
    levels = f"{sides[0]} levels of " if len(sides) > 2 else ""
    return f"{levels}{sides[-2]} by {sides[-1]}"


def _span(entries: Sequence[str], unit: str) -> str:
    unique = list(dict.fromkeys(entries))
    if not unique:
        return ""
    return f"{unique[0]} {unit}" if len(unique) == 1 else f"{unique[0]} to {unique[-1]} {unit}"


def setting_rows(settings: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Return (key, value, meaning) of every setting of a scenario; meanings come from the scenario's fields."""
    return [(key, shown(value), _meaning(key, settings)) for key, value in flat(settings) if key != "name"]


def shown(value: Any) -> str:
    """Format a setting's value."""
    if value is None:
        return "not set"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:g}"
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False, sort_keys=True)


def _meaning(key: str, settings: Mapping[str, Any]) -> str:
    here: type[BaseModel] | None = Scenario
    path = key.split(".")
    for part in path[:-1]:
        here = _part(here, part, settings) if here is not None else None
    if key == "fingerprint":
        return "Hash of the task; equal tasks have equal fingerprints."
    entry = here.model_fields.get(path[-1]) if here is not None else None
    return " ".join((entry.description or "").replace("``", "").split()) if entry is not None else ""


def _part(model: type[BaseModel], name: str, settings: Mapping[str, Any]) -> type[BaseModel] | None:
    """Return the model of a field; of several, the one whose ``source`` is that of the settings."""
    if name not in model.model_fields:
        return None
    annotation = model.model_fields[name].annotation
    options = [kind for kind in (annotation, *get_args(annotation)) if _is_model(kind)]
    source = settings.get(name, {}).get("source") if isinstance(settings.get(name), Mapping) else None
    tagged = [
        kind for kind in options if "source" in kind.model_fields and kind.model_fields["source"].default == source
    ]
    return next(iter(tagged or options), None)


def _is_model(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)
