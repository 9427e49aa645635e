"""Selects policies and scenarios, all of an experiment file or the entries named, and the baselines of ratios."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.errors import did_you_mean
from indoor_explorers.env.policies.registry import with_parameters
from indoor_explorers.env.scenarios.loading import named_scenario, scenario_for_comparison

#: The default policies: chance and the four families.
DEFAULT_POLICIES = ("random", "frontier-nearest", "frontier", "rrt", "pso", "dddqn")
DEFAULT_SCENARIO = "thesis-obstacles"
#: The default baseline of ratios of steps.
DEFAULT_BASELINE = "frontier-nearest"


def chosen_policies(asked: Sequence[Any] | None, listed: Sequence[Any] | None) -> list[Any]:
    """Return the policies asked for; the name of an entry of the file means that entry, with its parameters.

    Args:
        asked: names, such as ``pso`` or ``pso(length=1)``, or entries; None for all that the file lists.
        listed: the entries of the experiment file; None where there are none.

    Raises:
        InputError: what stands in the parentheses of a name are no parameters.

    """
    if asked is None:
        return list(DEFAULT_POLICIES if listed is None else listed)
    entries = {_policy_name(entry): entry for entry in listed or ()}
    return [entries.get(each) or _with_parameters(each) if isinstance(each, str) else each for each in asked]


def _with_parameters(name: str) -> Any:
    """Return ``pso(length=1)`` as an entry with these parameters; any other name as it is."""
    use, parameters = with_parameters(name)
    return {"use": use, "name": name.strip(), "parameters": parameters} if use != name else name


def _policy_name(entry: Any) -> str:
    name = (entry.get("name") or entry.get("use", "")) if isinstance(entry, Mapping) else entry
    return str(name).strip()


def chosen_scenarios(asked: Sequence[Any] | None, listed: Sequence[Any] | None, folder: Path) -> list[Scenario]:
    """Return the scenarios asked for as comparisons fly them; the name of an entry of the file means that entry.

    Args:
        asked: presets' names, ``.toml`` files or scenarios; None for all that the file lists.
        listed: the entries of the experiment file: presets' names, ``.toml`` files, or tables of settings; None where
            there are none.
        folder: the folder of the experiment file; paths in the file are relative to it.

    """
    if asked is None and listed is None:
        return [named_scenario(DEFAULT_SCENARIO).for_evaluation()]
    own = [_listed_scenario(entry, folder) for entry in listed or ()]
    if asked is None:
        return own
    entries = {scenario.name.strip(): scenario for scenario in own}
    return [_asked_scenario(name, entries) for name in asked]


def _asked_scenario(asked: str | Scenario, entries: Mapping[str, Scenario]) -> Scenario:
    if isinstance(asked, Scenario):
        return asked.for_evaluation()
    return entries.get(asked) or named_scenario(str(asked)).for_evaluation()


def _listed_scenario(entry: Any, folder: Path) -> Scenario:
    if isinstance(entry, Mapping):
        return scenario_for_comparison(entry, f"scenario {entry.get('name', '')!r} of the experiment", folder)
    if not isinstance(entry, str):
        raise InputError(f"expected scenarios to list presets, .toml files or tables of settings, got {entry!r}")
    return named_scenario(entry, folder).for_evaluation()


def chosen_baselines(names: Sequence[str], privileged: Sequence[str], asked: Sequence[str] | None = None) -> list[str]:
    """Return the baselines of ratios: those asked for, else one policy and those that know the map.

    The one policy is ``frontier-nearest`` where it takes part, else the first that does not know the map.

    Raises:
        InputError: no policy of that name takes part.

    """
    for name in asked or ():
        if name not in names:
            raise InputError(
                f"expected a policy that takes part to compare with, got {name!r}{did_you_mean(name, names)}"
            )
    if asked:
        return list(dict.fromkeys(asked))
    plain = [name for name in names if name not in privileged]
    usual = [DEFAULT_BASELINE] if DEFAULT_BASELINE in plain else plain[:1]
    return [*usual, *(name for name in names if name in privileged)]
