"""Open map files: regular files of a bounded size, and nothing else."""

from __future__ import annotations

import stat
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

from indoor_explorers.env.errors import InputError

Fits: TypeAlias = Callable[[tuple[int, int], float], object]
"""A check of a map's (H, W) in pixels and metres a pixel, which a reader calls as soon as it has read the header: it
raises :class:`InputError` if they make no usable map, before anything is decoded."""


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


def one_line(error: Exception) -> str:
    """Return the text of an error on one line."""
    return " ".join(str(error).split())[:200] or type(error).__name__
