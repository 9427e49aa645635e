"""Scenarios from TOML files and tables, which may start from a preset."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from indoor_explorers.env.errors import InputError, did_you_mean
from indoor_explorers.env.files import expanded
from indoor_explorers.env.scenarios.presets import PRESETS, scenario
from indoor_explorers.env.scenarios.scenario import COMPARED, Scenario
from indoor_explorers.env.scenarios.validation import read_toml, validated


def named_scenario(name: str, folder: Path | None = None) -> Scenario:
    """Return a preset by name, or the scenario of a ``.toml`` file, whose path may be relative to ``folder``."""
    if name.endswith(".toml"):
        return load_scenario((folder or Path()) / expanded(name))
    if name not in PRESETS:
        raise InputError(f"unknown scenario {name!r} (expected a preset or a .toml file){did_you_mean(name, PRESETS)}")
    return PRESETS[name]


def load_scenario(path: str | Path) -> Scenario:
    """Read a scenario from a TOML file; it may name a ``preset`` to start from.

    Paths of map files in it are relative to the file.
    """
    path = expanded(path)
    return scenario_from_table({"name": path.stem} | read_toml(path), str(path), path.parent)


def scenario_for_comparison(table: Mapping[str, Any], where: str, folder: Path) -> Scenario:
    """Return the scenario of an experiment's table, with the settings of :data:`COMPARED` that the table leaves out.

    The arguments are those of :func:`scenario_from_table`.
    """
    stated = _flattened(table)
    task = scenario_from_table(table, where, folder).for_evaluation()
    return task.with_settings({key: stated[key] for key in COMPARED if key in stated})


def scenario_from_table(table: Mapping[str, Any], where: str, folder: Path) -> Scenario:
    """Build a scenario from a TOML table, which may name a ``preset`` to start from.

    Args:
        table: The settings; others have the preset's value, or the default.
        where: The name of the table in errors.
        folder: The folder that paths of map files are relative to.

    """
    data = dict(table)
    maps = data.get("map")
    if isinstance(maps, dict) and isinstance(maps.get("paths"), list):
        data["map"] = maps | {"paths": [str(folder / expanded(str(one))) for one in maps["paths"]]}
    base = data.pop("preset", None)
    if base is None:
        return validated(Scenario, data, where)
    if not isinstance(base, str):
        raise InputError(f"{where}: expected preset to be the name of a scenario, got {base!r}")
    try:
        return scenario(base).with_settings(_flattened(data))
    except InputError as error:
        raise InputError(f"{where}: {error}") from error


def _flattened(data: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return nested tables as one table with dotted keys; a map table that names its source stays whole."""
    flat: dict[str, Any] = {}
    for key, value in data.items():
        if isinstance(value, dict) and "source" not in value:
            flat |= _flattened(value, f"{prefix}{key}.")
        else:
            flat[prefix + key] = value
    return flat
