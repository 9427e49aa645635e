"""Load plug-ins by their name in an entry-point group, or as ``module:attribute``."""

from __future__ import annotations

import hashlib
import importlib
import inspect
from collections.abc import Iterable
from functools import cache
from importlib.metadata import entry_points
from operator import attrgetter
from pathlib import Path
from typing import Any

from indoor_explorers.env.errors import InputError, described, did_you_mean

#: Groups of the plug-ins of a scenario: classes of map generators, and functions.
MAPS, LIDARS, RADIOS = (f"indoor_explorers.{what}" for what in ("maps", "lidars", "radios"))


@cache
def declared(group: str) -> dict[str, str]:
    """Return ``module:attribute`` of the plug-ins that installed distributions declare in a group, by name."""
    return {entry.name: entry.value for entry in sorted(entry_points(group=group), key=lambda entry: entry.name)}


def load_plugin(group: str, name: str, what: str, others: Iterable[str] = ()) -> Any:
    """Return the object of a name in a group, or of ``module:attribute``.

    Args:
        group: The entry-point group.
        name: The name.
        what: The kind of object, for errors, such as "map generator".
        others: Other accepted names that are no plug-ins, for errors.

    Raises:
        InputError: there is no such name, or its module cannot be imported.

    """
    target = declared(group).get(name, name)
    module, colon, attribute = target.partition(":")
    if not colon or not module or not attribute:
        known = [*others, *declared(group)]
        raise InputError(
            f"unknown {what} {name!r}{did_you_mean(name, known)}; expected one of {', '.join(known)}, or module:name"
        )
    try:
        found = importlib.import_module(module)
    except (Exception, SystemExit) as error:
        raise InputError(f"{what} {name!r}: importing {module} raised {described(error)}") from error
    try:
        return attrgetter(attribute)(found)
    except AttributeError as error:
        raise InputError(f"{what} {name!r}: module {module} has no {attribute!r}") from error


def is_own(plugin: Any) -> bool:
    """Return whether a class or function belongs to this package."""
    return str(plugin.__module__).partition(".")[0] == __name__.partition(".")[0]


def source_hash(plugin: Any) -> str:
    """Return a short hash of the source file of a class or function; empty if there is no file."""
    try:
        file = inspect.getsourcefile(plugin)
    except TypeError:
        return ""
    return hashlib.sha256(Path(file).read_bytes()).hexdigest()[:16] if file and Path(file).is_file() else ""
