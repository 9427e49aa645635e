"""Selects one episode of results by policy, scenario, map and seed; an ambiguous choice names the candidates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from indoor_explorers.env.errors import InputError, did_you_mean
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.results.results import Results

#: What tells the episodes of some results apart, in the order in which they are chosen by.
KEYS: dict[str, Callable[[Record], Any]] = {
    "policy": lambda record: record.policy,
    "scenario": lambda record: record.task.scenario,
    "map": lambda record: record.floorplan.name,
    "seed": lambda record: record.task.seed,
}
#: Names and numbers that an error lists.
LISTED = 8


def chosen_record(results: Results, where: str, wanted: dict[str, Any]) -> Record:
    """Return the one episode with the ``wanted`` values of some :data:`KEYS`; None is any value.

    Raises:
        InputError: there is none, or there are several.

    """
    found: Sequence[Record] = results.records
    for key, value_of in KEYS.items():
        wish = wanted.get(key)
        matching = [record for record in found if wish is None or value_of(record) == wish]
        if not matching:
            raise InputError(f"{where}: expected an episode with {key} {wish}, got none{_there_is(key, wish, found)}")
        found = matching
    if len(found) == 1:
        return found[0]
    several = _undecided(found)
    differing = "; ".join(_listed(key, found) for key in several)
    options = " and ".join(f"--{key}" for key in several)
    raise InputError(f"{where}: expected one episode, got {len(found)}: {differing}; choose with {options}")


def _undecided(records: Sequence[Record]) -> list[str]:
    """Return the keys that tell records apart where those before them do not."""
    keys = list(KEYS)
    values = [tuple(value_of(record) for value_of in KEYS.values()) for record in records]
    return [
        key
        for k, key in enumerate(keys)
        if len({each[: k + 1] for each in values}) > len({each[:k] for each in values})
    ]


def _there_is(key: str, wish: Any, records: Sequence[Record]) -> str:
    """Return what to choose instead."""
    if isinstance(wish, str):
        return did_you_mean(wish, {KEYS[key](record) for record in records})
    return f"; there are {_listed(key, records)}"


def _listed(key: str, records: Sequence[Record]) -> str:
    """Return a key with its values: names, and numbers in a row as a range."""
    values = sorted({KEYS[key](record) for record in records})
    shown = [str(value) for value in values[:LISTED]]
    if key == "seed" and len(values) > 2 and values[-1] - values[0] == len(values) - 1:
        shown = [f"{values[0]} to {values[-1]}"]
    elif len(values) > LISTED:
        shown.append(f"and {len(values) - LISTED} more")
    plural = "policies" if key == "policy" else f"{key}s"
    return f"{key if len(values) == 1 else plural} {', '.join(shown)}"
