"""Compares stored scenarios, and recomputes their fingerprints, which identify tasks."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from indoor_explorers.env.maps.sources import FileMaps
from indoor_explorers.env.scenarios.scenario import Scenario, hashed, task_facts
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.episodes.stored_names import outside_names
from indoor_explorers.evaluation.harness.results.database import damaged

#: Sources whose identity is that of their cells.
OF_CELLS = ("files", "office")


def refuse_other_fingerprints(
    path: Path, scenarios: Mapping[str, Mapping[str, Any]], records: Iterable[Record]
) -> None:
    """Refuse a store with a scenario that has the fingerprint of another task.

    Scenarios with code of plug-ins, or with map files that no episode was flown on, are not checked.
    """
    flown: dict[str, dict[int, set[str]]] = {name: defaultdict(set) for name in scenarios}
    for record in records:
        flown[record.task.scenario][record.task.map_index].add(record.floorplan.digest)
    for name, settings in scenarios.items():
        found = _fingerprint(settings, flown[name])
        if found not in (None, settings["fingerprint"]):
            raise damaged(
                path, f"scenario {name!r} has the fingerprint {settings['fingerprint']}, its settings and maps {found}"
            )


def comparable(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings that scenarios of one fingerprint have in common, and the number of levels of map files."""
    maps = settings.get("map", {})
    if maps.get("source") in OF_CELLS:
        maps = {"source": maps["source"], "levels": _level_count(maps)}
    return task_facts(settings) | {"map": maps}


def task_difference(fingerprint: str, settings: Mapping[str, Any], scenario: Scenario) -> str:
    """Return what a scenario has otherwise than stored settings with a fingerprint; empty if the tasks are the same."""
    if fingerprint != scenario.fingerprint:
        return f"the settings of scenario {scenario.name!r}"
    there, here = _level_count(settings["map"]), scenario.map.level_count
    if not isinstance(scenario.map, FileMaps) or there == here:
        return ""
    return f"levels of scenario {scenario.name!r} ({there} there, {here} here: omit or set map.least_levels)"


def _level_count(maps: Mapping[str, Any]) -> int:
    """Return the levels of stored map files, which have one where nothing is said."""
    return int(maps.get("levels", 1))


def _fingerprint(settings: Mapping[str, Any], flown: Mapping[int, set[str]]) -> str | None:
    """Return the fingerprint of stored settings and of the maps ``flown`` by index; None if unknown."""
    maps = settings["map"]
    if outside_names(settings):
        return None
    if maps["source"] in OF_CELLS:
        cells = ["/".join(sorted(flown[index])) for index, _ in enumerate(maps.get("paths", ["the office"]))]
        if not all(cells):
            return None
        maps = {"source": maps["source"], "cells": cells}
    return hashed(task_facts(settings) | {"map": maps})
