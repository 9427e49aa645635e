"""How the fields of a request are given on the command line, and how their values are parsed."""

from __future__ import annotations

import csv
import io
import re
import tomllib
from argparse import ArgumentTypeError
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, kw_only=True)
class Option:
    """Marks a field as a command-line option; the field's docstring is its help text."""

    metavar: str | None = None
    """The placeholder for the value in the help text."""
    read: Callable[[str], Any] = str
    """Parses an argument; raises ``ArgumentTypeError`` for invalid ones."""
    several: bool = False
    """Whether it takes several values, and may be given several times."""
    choices: tuple[str, ...] | None = None
    """The allowed values; None for any."""
    flag: str | None = None
    """The flag, such as ``--set``; None: the name of the field, with dashes for underscores."""
    positional: bool = False
    """Whether it is a positional argument."""


def read_setting(text: str) -> tuple[str, Any]:
    """Read ``key=value``; the value is parsed as TOML, and is a string where it is not TOML.

    Values separated by commas make a list, as in ``radio.range=1,3,5``.
    """
    key, equals, value = text.partition("=")
    if not equals or not key:
        raise ArgumentTypeError(f"expected key=value such as goal=0.9, got {text!r}")
    try:
        return key, _toml(value)
    except ValueError:  # not TOML, or an integer of thousands of digits
        return key, _several(value) if "," in value else value


def _toml(text: str) -> Any:
    (value,) = tomllib.loads(f"value = {text}").values()
    return value


def _several(text: str) -> list[Any]:
    try:
        return list(_toml(f"[{text}]"))
    except ValueError:
        return [word.strip() for word in text.split(",")]


def read_names(text: str) -> list[str]:
    """Read names separated by commas; one in double quotes may hold commas, as in CSV, and so may its parentheses."""
    kept = re.sub(r"\([^()]*\)", lambda inside: inside[0].replace(",", "\0"), text)
    rows = csv.reader(io.StringIO(kept, newline=""), skipinitialspace=True)
    names = [name.replace("\0", ",").strip() for row in rows for name in row if name.strip()]
    if not names:
        raise ArgumentTypeError("expected names separated by commas, got none")
    return names


def _number(kind: type, least: float, what: str, below: float = float("inf")) -> Callable[[str], Any]:
    def read(text: str) -> Any:
        try:
            value = kind(text)
        except ValueError:
            value = None
        if value is None or not least <= value < below:
            raise ArgumentTypeError(f"expected {what}, got {text!r}")
        return value

    return read


read_count = _number(int, 1, "a whole number of at least 1")
read_natural = _number(int, 0, "a whole number of at least 0")
read_metres = _number(float, 1e-6, "a number of metres above 0")
read_seconds = _number(float, 0.01, "a number of seconds of at least 0.01")
read_gigabytes = _number(float, 0.01, "a number of gigabytes of at least 0.01")
read_speed = _number(float, 0.001, "a number of metres a second of at least 0.001")
read_share = _number(float, 0, "a share below 1 such as 0.05, or 0 for none", below=1)
read_rate = _number(float, 0.1, "a number of frames a second of at least 0.1")
