"""Names in results of code from outside this package, which is imported only if the user names it too.

Results are untrusted data. Their scenarios may name models of plug-ins, and their policies modules and files of any
machine. Code from outside this package is imported only if it is in ``plugins``: the names that the user gave, each
spelt as it is stored.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from shlex import quote
from typing import Any

from indoor_explorers.env.maps.sources import SOURCES
from indoor_explorers.env.policies.registry import is_own_policy, policy_entry_points
from indoor_explorers.env.scenarios.codes import LIDAR_MODELS, RADIO_MODELS

#: The settings that name a model of the world, and those that name any code, with the names of this package.
MODELS: Mapping[str, Sequence[str]] = {"lidar.model": LIDAR_MODELS, "radio.model": RADIO_MODELS}
NAMING: Mapping[str, Sequence[str]] = {**MODELS, "map.source": tuple(SOURCES)}


def outside_names(settings: Mapping[str, Any], naming: Mapping[str, Sequence[str]] = NAMING) -> dict[str, str]:
    """Return what a stored scenario names from outside this package, by setting."""
    found = {place: _at(settings, place) for place in naming}
    return {place: str(name) for place, name in found.items() if name is not None and name not in naming[place]}


def refusal(settings: Mapping[str, Any], plugins: Collection[str], naming: Mapping[str, Sequence[str]] = NAMING) -> str:
    """Say what a stored scenario names from outside that is not in ``plugins``, and how to name it; empty for none."""
    return _line([pair for pair in outside_names(settings, naming).items() if pair[1] not in plugins])


def policy_refusal(choice: Mapping[str, Any], plugins: Collection[str]) -> str:
    """Say what a stored policy, an entry of the experiment, names from outside; see :func:`refusal`.

    A policy that this package declares is its own, unless it is given a text that could lead to a module, to a file
    or to a policy of others.
    """
    use, parameters = str(choice.get("use")), choice.get("parameters")
    needed = [("policy", use)] if use not in policy_entry_points() or _leads_outside(use) else []
    needed += [("parameter", text) for text in _texts(parameters) if _leads_outside(text)]
    return _line([pair for pair in needed if pair[1] not in plugins])


def with_own_models(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return stored settings with models of this package in place of those from outside, to validate the rest."""
    replaced = dict(settings)
    for place in outside_names(settings, MODELS):
        part, _, key = place.partition(".")
        replaced[part] = {**settings[part], key: MODELS[place][0]}
    return replaced


def _line(unnamed: Sequence[tuple[str, str]]) -> str:
    """Return the line about (kind, name) pairs that the user did not name; empty for none."""
    listed = " and ".join(f"{what} {name!r}" for what, name in unnamed)
    names = ",".join(dict.fromkeys(name for _, name in unnamed))
    return listed and f"{listed} from outside this package, imported only if you name it: --plugins {quote(names)}"


def _at(settings: Mapping[str, Any], place: str) -> Any:
    part, _, key = place.partition(".")
    table = settings.get(part)
    return table.get(key) if isinstance(table, Mapping) else None


def _leads_outside(text: str) -> bool:
    return ":" in text or "/" in text or (text in policy_entry_points() and not is_own_policy(text))


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping):
        for each in value.values():
            yield from _texts(each)
    elif isinstance(value, Sequence):
        for each in value:
            yield from _texts(each)
