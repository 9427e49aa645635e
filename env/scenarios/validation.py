"""Read and validate settings written by a user; errors are one clear line."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from indoor_explorers.env.errors import InputError, did_you_mean
from indoor_explorers.env.maps.sources import SOURCES

#: Messages for pydantic's types of errors, in the terms of TOML.
_PLAINLY = {
    **dict.fromkeys(("model_type", "model_attributes_type"), "expected a table of settings"),
    **dict.fromkeys(("union_tag_invalid", "union_tag_not_found"), "expected a kind of map"),
    "tuple_type": "expected a list",
}

#: Largest TOML file that is read.
MOST_BYTES = 1_000_000

Model = TypeVar("Model", bound=BaseModel)


def read_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file; raise :class:`InputError` with one line for any fault."""
    try:
        size = path.stat().st_size
        text = path.read_bytes() if size <= MOST_BYTES else b""
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    if size > MOST_BYTES:
        raise InputError(f"{path}: expected a TOML file of at most 1 MB, got {size} bytes")
    try:
        return tomllib.loads(text.decode())
    except (ValueError, RecursionError) as error:  # not TOML, not UTF-8, or an integer of thousands of digits
        raise InputError(f"{path}: expected TOML, got {error}") from error


def validated(model: type[Model], data: Mapping[str, Any], where: str) -> Model:
    """Build a pydantic model, turning its first error into one line with a did-you-mean."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        first = error.errors()[0]
        place = _place(first["loc"])
        if first["type"] == "extra_forbidden":
            key = str(first["loc"][-1])
            raise InputError(
                f"{where}: unknown key {place!r}{did_you_mean(key, _known_keys(model, first['loc'][:-1]))}"
            ) from error
        message = first["msg"].removeprefix("Value error, ")
        message, value, hint = _PLAINLY.get(first["type"], message), first["input"], ""
        if first["type"].startswith("union_tag"):
            value = first["ctx"].get("tag", "none")
            place, hint = f"{place}.source", did_you_mean(value, SOURCES)
        shown = _shown(value)
        received = f", got {shown}{hint}" if place and len(shown) < 80 else ""
        raise InputError(f"{where}: {place + ': ' if place else ''}{message}{received}") from error


def _shown(value: object) -> str:
    try:
        return repr(value)
    except ValueError:  # Python prints no integer of more than 4,300 digits
        return "a number of thousands of digits"


def _place(location: tuple[int | str, ...]) -> str:
    """Return the location of an error as a dotted key, without the source that pydantic adds after ``map``."""
    parts = zip(("", *location), location, strict=False)
    return ".".join(str(part) for before, part in parts if not (before == "map" and part in SOURCES))


def _known_keys(model: type[BaseModel], where: tuple[int | str, ...]) -> list[str]:
    """List the field names of the (possibly nested) model at an error's location."""
    kinds: list[type[BaseModel]] = [model]
    for part in where:
        tagged = [
            kind for kind in kinds if "source" in kind.model_fields and kind.model_fields["source"].default == part
        ]
        annotations = [kind.model_fields[str(part)].annotation for kind in kinds if part in kind.model_fields]
        nested = [
            option
            for annotation in annotations
            for option in (annotation, *get_args(annotation))
            if isinstance(option, type) and issubclass(option, BaseModel)
        ]
        kinds = tagged or nested or kinds
    return list(kinds[0].model_fields)
