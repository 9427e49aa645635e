"""What of an experiment file is flown: all of it, the entries that were named, or something else instead."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.presets import named_scenario

#: Compared when nothing else is asked for: chance and the four families.
DEFAULT_POLICIES = ("random", "frontier-nearest", "frontier-minpos", "rrt-frontier", "pso", "dddqn")
DEFAULT_SCENARIO = "thesis-obstacles"


def chosen_policies(asked: Sequence[Any] | None, listed: Sequence[Any] | None) -> list[Any]:
    """Return the policies asked for; the name of an entry of the file means that entry with its parameters.

    Args:
        asked: names, or whole entries; None asks for all that the file lists.
        listed: the entries of the experiment file; None where there are none.

    """
    if asked is None:
        return list(DEFAULT_POLICIES if listed is None else listed)
    entries = {_policy_name(entry): entry for entry in listed or ()}
    return [entries.get(each, each) if isinstance(each, str) else each for each in asked]


def _policy_name(entry: Any) -> str:
    name = (entry.get("name") or entry.get("use", "")) if isinstance(entry, Mapping) else entry
    return str(name).strip()


def chosen_scenarios(asked: Any, listed: Sequence[Any] | None, folder: Path) -> list[Scenario]:
    """Return the scenarios asked for in the form comparisons fly; the name of an entry of the file means that entry.

    Args:
        asked: a preset's name, a ``.toml`` file or a scenario, or several; None asks for all that the file lists.
        listed: the entries of the experiment file: presets' names, ``.toml`` files, or tables of settings; None where
            there are none.
        folder: where the experiment file lies; paths in it are relative to it.

    """
    if asked is None and listed is None:
        return [named_scenario(DEFAULT_SCENARIO).for_evaluation()]
    own = [_listed_scenario(entry, folder) for entry in listed or ()]
    if asked is None:
        return own
    entries = {scenario.name.strip(): scenario for scenario in own}
    names = [asked] if isinstance(asked, (str, Scenario)) else list(asked)
    return [_asked_scenario(name, entries) for name in names]


def _asked_scenario(asked: str | Scenario, entries: Mapping[str, Scenario]) -> Scenario:
    if isinstance(asked, Scenario):
        return asked.for_evaluation()
    return entries.get(asked) or named_scenario(str(asked)).for_evaluation()


def _listed_scenario(entry: Any, folder: Path) -> Scenario:
    if isinstance(entry, Mapping):
        return Scenario.for_comparison(entry, f"scenario {entry.get('name', '')!r} of the experiment", folder)
    if not isinstance(entry, str):
        raise InputError(f"expected scenarios to list presets, .toml files or tables of settings, got {entry!r}")
    return named_scenario(entry, folder).for_evaluation()
