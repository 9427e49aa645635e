"""Read JSON maps: bounded files, numbers as floats, and values in a few characters for errors."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.maps.readers.opening import one_line, read_bytes

#: The most bytes a file may have; real ones have some thousand to half a million.
MAX_BYTES = 4_000_000


def read_json(path: Path) -> Any:
    """Return the content of a JSON file; raise :class:`InputError` with one line that says what is wrong with it."""
    text = read_bytes(path, MAX_BYTES, "a JSON map")
    try:
        return json.loads(text, parse_int=float)  # of any number of digits, in time that grows with them alone
    except RecursionError as error:
        raise InputError(f"{path}: expected a JSON map, got JSON nested too deeply; is it one?") from error
    except ValueError as error:
        raise InputError(f"{path}: expected JSON, got {one_line(error)}; correct it") from error


def shown(value: Any) -> str:
    """Return a JSON value in a few characters."""
    if isinstance(value, list):
        return f"a list of {len(value)}" if len(value) != 2 else f"[{', '.join(shown(part) for part in value)}]"
    return repr(value)[:30] if isinstance(value, float | str | bool) else f"a JSON {kind(value)}"


def finite(value: Any) -> bool:
    """Tell whether a JSON value is a finite number."""
    return isinstance(value, float) and math.isfinite(value)


def kind(value: Any) -> str:
    """Return what JSON calls the type of a value."""
    names = {dict: "object", list: "list", str: "text", float: "number", bool: "true or false"}
    return names.get(type(value), "null")
