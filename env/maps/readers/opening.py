"""Open map files of bounded size, JSON and YAML in particular, and describe their faults in one line."""

from __future__ import annotations

import json
import math
import stat
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeAlias

from indoor_explorers.env.errors import InputError

#: The most bytes of a JSON file; real ones have some thousand to half a million.
MAX_JSON_BYTES = 4_000_000
#: The most pixels a map file may have (6,000 x 6,000), so that decoding it cannot exhaust the memory.
MAX_PIXELS = 36_000_000

Fits: TypeAlias = Callable[[tuple[int, int], float], object]
"""A check of a map's (H, W) in pixels and metres a pixel, which a reader calls after the header and before decoding: it
raises :class:`InputError` if the map would be unusable."""


def check_file(path: Path) -> None:
    """Raise :class:`InputError` unless ``path`` is a regular file."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError as error:
        raise InputError(f"{path}: expected a file, got a path where there is none; correct the path") from error
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or one_line(error)
        raise InputError(f"{path}: cannot be read: {reason}; correct the path or its permissions") from error
    if stat.S_ISDIR(mode):
        raise InputError(f"{path}: expected a file, got a directory; name the map files in it")
    if not stat.S_ISREG(mode):
        raise InputError(f"{path}: expected a regular file, got a pipe or device; copy it to a file first")


def read_bytes(path: Path, most: int, what: str) -> bytes:
    """Return the content of a file of at most ``most`` bytes; ``what`` names its kind in the error."""
    check_file(path)
    try:
        if (size := path.stat().st_size) > most:
            raise InputError(f"{path}: expected {what} of at most {most:,} bytes, got {size:,}; is it one?")
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}; check its permissions") from error


def check_pixels(path: Path, shape: tuple[int, ...], what: str = "pixels") -> None:
    """Raise :class:`InputError` for a map of more than :data:`MAX_PIXELS` pixels, (H, W); ``what`` names these."""
    height, width = shape
    if height * width > MAX_PIXELS:
        raise InputError(f"{path}: expected at most {MAX_PIXELS:,} {what}, got {height:,} x {width:,}; scale it down")


@contextmanager
def decoding(path: Path, what: str) -> Iterator[None]:
    """Turn every error of a decoder of a regular file into :class:`InputError`; ``what`` names the expected content."""
    check_file(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except InputError:
        raise
    except OSError as error:
        reason = error.strerror or one_line(error)
        raise InputError(f"{path}: cannot be read: {reason}; check it, or save it again") from error
    except Exception as error:  # decoders raise many kinds of errors on broken files
        raise InputError(f"{path}: expected {what}, got {one_line(error)}; save it again") from error


def read_json(path: Path) -> Any:
    """Return the content of a JSON file; raise :class:`InputError` if it is none."""
    text = read_bytes(path, MAX_JSON_BYTES, "a JSON map")
    try:
        return json.loads(text, parse_int=float)  # in linear time for any number of digits
    except RecursionError as error:
        raise InputError(f"{path}: expected a JSON map, got JSON nested too deeply; is it one?") from error
    except ValueError as error:
        raise InputError(f"{path}: expected JSON, got {one_line(error)}; correct it") from error


def read_yaml(path: Path, most: int, deepest: int, such: str, what: str) -> Mapping[str, Any]:
    """Return the mapping in a YAML file with all scalars as text: no tags, merges or guesses at types.

    A file has at most so many bytes and levels of nesting; ``such`` is a line of it, and ``what`` its kind, for errors.
    """
    import yaml  # here, since most maps are others

    loader: Any = getattr(yaml, "CBaseLoader", yaml.BaseLoader)  # libyaml's is ten times as fast
    text = read_bytes(path, most, what).decode("utf-8-sig", errors="replace")
    depth = 0
    try:
        for event in yaml.parse(text, Loader=loader):
            depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
            if depth > deepest:
                raise InputError(f"{path}: expected a plain list of keys, got YAML nested deeper than {deepest} levels")
        data = yaml.load(text, Loader=loader)
    except yaml.YAMLError as error:
        raise InputError(f"{path}: expected YAML, got {one_line(error)}; correct it") from error
    if not isinstance(data, dict) or not data:
        got = "an empty file" if not data else "a list" if isinstance(data, list) else "plain text"
        raise InputError(f"{path}: expected lines such as {such!r}, got {got}; is it {what}?")
    return data


def shown(value: Any) -> str:
    """Return a short description of a JSON value."""
    if isinstance(value, list):
        return f"a list of {len(value)}" if len(value) != 2 else f"[{', '.join(shown(part) for part in value)}]"
    return repr(value)[:30] if isinstance(value, float | str | bool) else f"a JSON {kind(value)}"


def finite(value: Any) -> bool:
    """Tell whether a JSON value is a finite number."""
    return isinstance(value, float) and math.isfinite(value)


def kind(value: Any) -> str:
    """Return the JSON name of the type of a value."""
    names = {dict: "object", list: "list", str: "text", float: "number", bool: "true or false"}
    return names.get(type(value), "null")


def one_line(error: Exception) -> str:
    """Return the text of an error on one line."""
    return " ".join(str(error).split())[:200] or type(error).__name__
