"""Whether two results are of the same version of a policy, and what differs if not."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from indoor_explorers.evaluation.harness.experiment.sources import changed_files

#: Limits of a message: fields named, and characters of a value.
NAMED, SHOWN = 8, 60
#: Facts about a policy that follow from the others; older stores do not have all of them.
DERIVED_FACTS = (
    *("uses_generator", "batched", "defaults", "hash", "weights_for", "failed_check", "seen_seeds", "plans_for"),
    *("isolated", "seen_maps", "flown_again", "map_shape", "renamed"),
)


def identity(about: Mapping[str, Any], older: Mapping[str, Any]) -> dict[str, Any]:
    """Return the facts by which a policy is recognised; its sources are compared file by file.

    Parameters have their present names. One that an ``older`` version did not have is left out where it has its
    default.
    """
    kept = {key: value for key, value in about.items() if key not in (*DERIVED_FACTS, "sources")}
    renamed = {**older.get("renamed", {}), **about.get("renamed", {})}
    defaults = present_parameters(about.get("defaults", {}), renamed)
    known = present_parameters(older.get("parameters", {}), renamed)
    parameters = {
        name: value
        for name, value in present_parameters(about.get("parameters", {}), renamed).items()
        if name in known or name not in defaults or value != defaults[name]
    }
    return kept | ({"parameters": parameters} if "parameters" in kept else {})


def present_parameters(stored: Mapping[str, str], renamed: Mapping[str, Sequence[str]]) -> dict[str, str]:
    """Return the stored texts of parameters by their present names, those inside objects of parameters dotted."""
    found: dict[str, str] = {}
    for name, value in flat({name: _spelt_out(text) for name, text in stored.items()}):
        for present in renamed.get(name, (name,)):
            found[present] = value
    return found


def _spelt_out(text: str) -> str | dict[str, Any]:
    """Return the text of an object of parameters as the texts of these; any other as it is."""
    if not text.startswith("{"):
        return text
    try:
        inside = ast.literal_eval(text)
    except (ValueError, SyntaxError, MemoryError, RecursionError):
        return text
    return {str(name): repr(value) for name, value in inside.items()} if isinstance(inside, dict) and inside else text


def version_difference(before: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    """Return in what two policies of one name differ, empty if they are the same version.

    Sources are compared where both sides stored them.
    """
    ours, theirs = identity(before, now), identity(now, before)
    files = changed_files(before.get("sources"), now.get("sources"))
    if ours == theirs and not files:
        return ""
    more = [f"and {len(files) - NAMED} more files"] if len(files) > NAMED else []
    return ", ".join(filter(None, [differing_fields(ours, theirs), *files[:NAMED], *more]))


def differing_fields(one: Mapping[str, Any], other: Mapping[str, Any], *, aside: Sequence[str] = ()) -> str:
    """Name the fields in which two nested mappings differ in dotted form, such as ``radio.range (3.0 and 4.0)``."""
    ours, theirs = dict(flat(one)), dict(flat(other))
    differing = [
        f"{key} ({_value(ours, key)} and {_value(theirs, key)})"
        for key in dict.fromkeys((*ours, *theirs))
        if key not in aside and ours.get(key) != theirs.get(key)
    ]
    more = f" and {len(differing) - NAMED} more" if len(differing) > NAMED else ""
    return ", ".join(differing[:NAMED]) + more


def flat(settings: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the values of a nested mapping with their dotted keys."""
    for key, value in settings.items():
        if isinstance(value, Mapping):
            yield from flat(value, f"{prefix}{key}.")
        else:
            yield prefix + key, value


def _value(fields: Mapping[str, Any], key: str) -> str:
    text = str(fields[key]) if fields.get(key) is not None else "not set"
    return text if len(text) <= SHOWN else text[: SHOWN - 1] + "…"
