"""Command-line options made from the fields of a request."""

from __future__ import annotations

import argparse
from typing import Any

from pydantic.fields import FieldInfo

from indoor_explorers.evaluation.harness.experiment.request import Request
from indoor_explorers.evaluation.harness.options import Option


def add_options(parser: argparse.ArgumentParser, request: type[Request]) -> None:
    """Add an option for every field marked as one; options that are not given are missing in the parsed namespace."""
    for name, field in request.model_fields.items():
        for option in field.metadata:
            if isinstance(option, Option):
                words = _words(name, field, option)
                parser.add_argument(*words.pop("flags"), default=argparse.SUPPRESS, help=_help(field), **words)


def _words(name: str, field: FieldInfo, option: Option) -> dict[str, Any]:
    if option.positional:
        several = {"nargs": "+" if field.is_required() else "*"} if option.several else {}
        return {"flags": [name], "type": option.read, "metavar": option.metavar, **several}
    words: dict[str, Any] = {"flags": [option.flag or "--" + name.replace("_", "-")], "dest": name}
    words["required"] = field.is_required()
    if field.annotation is bool:
        return words | {"action": "store_true"}
    words |= {"type": option.read, "metavar": option.metavar, "choices": option.choices}
    return words | {"nargs": "+", "action": "extend"} if option.several else words


def _help(field: FieldInfo) -> str:
    """Return the docstring of a field, with its default where that is a word or a number."""
    text = " ".join((field.description or "").split())
    if isinstance(field.default, (str, int, float)) and not isinstance(field.default, bool):
        text += f" Default: {field.default if isinstance(field.default, str) else format(field.default, 'g')}."
    return text.replace("%", "%%")
