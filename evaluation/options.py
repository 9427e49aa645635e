"""How the fields of a request are written on the command line: a word is read into a value, or refused in one line."""

from __future__ import annotations

import csv
import io
import tomllib
from argparse import ArgumentTypeError
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, kw_only=True)
class Option:
    """Marks a field as an option of the command line; the field's docstring is its help."""

    metavar: str | None = None
    """What stands for the value in the help."""
    read: Callable[[str], Any] = str
    """Turns a word into a value."""
    several: bool = False
    """Whether it takes several words, and may be given several times."""
    choices: tuple[str, ...] | None = None
    """The words it takes; None for any."""
    flag: str | None = None
    """How it is spelled, such as ``--set``; None: as the field, with dashes for underscores."""
    positional: bool = False
    """Whether it is given without a flag."""


def read_setting(text: str) -> tuple[str, Any]:
    """Read ``key=value``; the value is TOML where it is TOML, else a plain word."""
    key, equals, value = text.partition("=")
    if not equals or not key:
        raise ArgumentTypeError(f"expected key=value such as goal=0.9, got {text!r}")
    try:
        return key, tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        return key, value


def read_names(text: str) -> list[str]:
    """Read names separated by commas; one in double quotes may hold commas, as in CSV."""
    rows = csv.reader(io.StringIO(text, newline=""), skipinitialspace=True)
    names = [name.strip() for row in rows for name in row if name.strip()]
    if not names:
        raise ArgumentTypeError("expected names separated by commas, got none")
    return names


def _number(kind: type, least: float, what: str) -> Callable[[str], Any]:
    def read(text: str) -> Any:
        try:
            value = kind(text)
        except ValueError:
            value = None
        if value is None or not least <= value < float("inf"):
            raise ArgumentTypeError(f"expected {what}, got {text!r}")
        return value

    return read


read_count = _number(int, 1, "a whole number of at least 1")
read_natural = _number(int, 0, "a whole number of at least 0")
read_metres = _number(float, 1e-6, "a number of metres above 0")
read_seconds = _number(float, 0.01, "a number of seconds of at least 0.01")
read_gigabytes = _number(float, 0.01, "a number of gigabytes of at least 0.01")
read_rate = _number(float, 0.1, "a number of frames a second of at least 0.1")
