"""Finds sweeps: scenarios that differ only in the range of the radio, the number of UAVs, or one other number."""

from __future__ import annotations

import copy
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

Settings = Mapping[str, Any]

#: Settings of a scenario that do not change the task.
NOMINAL = ("name", "fingerprint")
#: Settings that only matter for teams.
OF_TEAMS = (("radio",), ("rewards", "received"), ("goal_of",))
#: Titles of settings that are often swept, and the settings that have the value together; others have their keys.
TITLES = {
    "lidar range [cells]": (("lidar", "range"),),
    "side of the map [cells]": (("map", "height"), ("map", "width")),
    "obstacles": (("map", "obstacles"),),
}
#: Settings whose sweeps have panels of their own.
ELSEWHERE = (("team",), ("radio", "range"))
#: Fewest values of such a sweep; two scenarios often differ in one setting without being meant as a sweep.
FEWEST_VALUES = 3


@dataclass(frozen=True)
class RadioSweep:
    """Scenarios that differ only in the range of the radio, by rising range."""

    model: str
    """Radio model of the ranges that are neither 0 nor unlimited."""
    team: int
    scenarios: tuple[str, ...]
    reaches: tuple[float, ...]
    """Cells: 0 without radio, infinite when unlimited."""


@dataclass(frozen=True)
class TeamScaling:
    """Scenarios that differ only in the number of UAVs, one UAV first."""

    scenarios: tuple[str, ...]
    teams: tuple[int, ...]


@dataclass(frozen=True)
class SettingSweep:
    """Scenarios that differ only in one setting that is a number, or in both sides of the map, by rising value."""

    setting: str
    """Its title."""
    scenarios: tuple[str, ...]
    values: tuple[float, ...]


def reach(settings: Settings) -> float:
    """Return how far the radio of a scenario reaches, in cells: 0 without one, infinite when unlimited."""
    radio = settings["radio"]
    return {"none": 0.0, "unlimited": math.inf}.get(radio["model"], float(radio["range"]))


def radio_sweeps(scenarios: Mapping[str, Settings]) -> list[RadioSweep]:
    """Return the sweeps of at least two ranges, in the order of their first scenario.

    The models ``none`` and ``unlimited`` are the ends of every sweep that they fit; ``disc`` and
    ``square`` make separate sweeps.
    """
    families: dict[str, dict[str, Settings]] = {}
    for name, settings in scenarios.items():
        if settings["team"] > 1:
            families.setdefault(_key(settings, ("radio",)), {})[name] = settings
    return [sweep for family in families.values() for kind in _kinds(family) for sweep in _sweep(family, kind)]


class _Radio(NamedTuple):
    """The settings of a radio other than its range; unused ones are None."""

    model: str
    loss: float
    walls: tuple[float, float] | None


def _kind(settings: Settings) -> _Radio:
    radio = settings["radio"]
    walls = (radio["exponent"], radio["wall_loss"]) if radio["model"] == "path-loss" else None
    return _Radio(radio["model"], radio.get("loss", 0.0), walls)


def _kinds(family: Mapping[str, Settings]) -> list[_Radio]:
    """Return the radios of limited range in a family; where it has none, the unlimited ones."""
    reaching = [settings for settings in family.values() if reach(settings) > 0]
    limited = [settings for settings in reaching if reach(settings) < math.inf]
    return list(dict.fromkeys(_kind(settings) for settings in limited or reaching))


def _sweep(family: Mapping[str, Settings], kind: _Radio) -> list[RadioSweep]:
    names = sorted((name for name in family if _fits(family[name], kind)), key=lambda name: reach(family[name]))
    reaches = tuple(reach(family[name]) for name in names)
    team = family[names[0]]["team"]
    return [RadioSweep(kind.model, team, tuple(names), reaches)] if len(set(reaches)) > 1 else []


def _fits(settings: Settings, kind: _Radio) -> bool:
    far = reach(settings)
    if far == 0:
        return True
    return _kind(settings).loss == kind.loss if far == math.inf else _kind(settings) == kind


def team_scalings(scenarios: Mapping[str, Settings]) -> list[TeamScaling]:
    """Return the families with one UAV and at least one team, those with most teams first.

    Spawns that are listed cell by cell are taken as alike, since they cannot be the same for other teams.
    """
    alone = {name: settings for name, settings in scenarios.items() if settings["team"] == 1}
    families: dict[str, dict[int, str]] = {}
    for name, settings in scenarios.items():
        if settings["team"] > 1:
            families.setdefault(_key(settings, ("team",)), {}).setdefault(settings["team"], name)
    found = []
    for family in families.values():
        solo_key = _key(scenarios[next(iter(family.values()))], ("team",), *OF_TEAMS)
        solo = next((name for name, each in alone.items() if _key(each, ("team",), *OF_TEAMS) == solo_key), None)
        if solo is not None:
            teams = sorted(family)
            found.append(TeamScaling((solo, *(family[team] for team in teams)), (1, *teams)))
    return sorted(found, key=lambda scaling: -len(scaling.teams))


def setting_sweeps(scenarios: Mapping[str, Settings]) -> list[SettingSweep]:
    """Return the sweeps of at least three values of a setting: :data:`TITLES` in their order, then other settings.

    A scenario may belong to several: to one sweep of each setting.
    """
    titled = [place for places in TITLES.values() for place in places]
    numbers = {place for settings in scenarios.values() for place in _numbers(settings)}
    others = {".".join(place): (place,) for place in sorted(numbers) if place not in (*titled, *ELSEWHERE)}
    swept = {**TITLES, **others}
    return [sweep for title, places in swept.items() for sweep in _sweeps_of(title, places, scenarios)]


def _numbers(settings: Settings, *parents: str) -> Iterator[tuple[str, ...]]:
    """Yield the places of the settings that are numbers."""
    for key, value in settings.items():
        if isinstance(value, Mapping):
            yield from _numbers(value, *parents, key)
        elif isinstance(value, (int, float)) and not isinstance(value, bool):
            yield (*parents, key)


def _value_at(settings: Settings, place: tuple[str, ...]) -> Any:
    value: Any = settings
    for key in place:
        value = value.get(key) if isinstance(value, Mapping) else None
    return value


def _sweeps_of(
    title: str, places: tuple[tuple[str, ...], ...], scenarios: Mapping[str, Settings]
) -> Iterator[SettingSweep]:
    families: dict[str, dict[float, str]] = {}
    for name, settings in scenarios.items():
        found = [_value_at(settings, place) for place in places]
        if all(isinstance(value, (int, float)) for value in found) and len(set(found)) == 1:
            families.setdefault(_key(settings, *places), {}).setdefault(float(found[0]), name)
    for family in families.values():
        if len(family) >= FEWEST_VALUES:
            values_up = sorted(family)
            yield SettingSweep(title, tuple(family[value] for value in values_up), tuple(values_up))


def _key(settings: Settings, *ignored: tuple[str, ...]) -> str:
    """Return all settings of a task except the ignored ones, as text to compare."""
    facts = copy.deepcopy({key: value for key, value in settings.items() if key not in NOMINAL})
    for *parents, leaf in ignored:
        place = facts
        for parent in parents:
            place = place.get(parent, {})
        place.pop(leaf, None)
    if not isinstance(facts.get("spawn", ""), str):
        facts["spawn"] = "listed"
    return json.dumps(facts, sort_keys=True)
