"""Paths that users give, and files and folders that are written completely or not at all."""

from __future__ import annotations

import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from uuid import uuid4

from filelock import FileLock, Timeout

from indoor_explorers.env.errors import InputError, shown


def expanded(path: str | Path) -> Path:
    """Return a path with a leading ``~`` replaced by the home folder, unless the user is unknown.

    Raises:
        InputError: it is no path, as a parameter that was meant as one may be.

    """
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"expected a path, got {shown(path)}")
    return Path(os.path.expanduser(path))  # noqa: PTH111, pathlib's raises for users that do not exist


@contextmanager
def writable(path: Path, option: str) -> Iterator[None]:
    """Tell a user whose files cannot be written to choose another path with ``option``.

    Raises:
        InputError: a file cannot be written.

    """
    try:
        yield
    except OSError as error:
        raise InputError(
            f"{error.filename or path}: cannot be written: {error.strerror}; choose another {option}"
        ) from error


@contextmanager
def alone_in(folder: Path, option: str) -> Iterator[None]:
    """Keep other processes that ask for the same out of a folder; the system lets them in when this process ends.

    Raises:
        InputError: another process is in it.

    """
    with locked(folder / ".lock") as alone:
        if not alone:
            raise InputError(f"{folder}: another process writes here; wait for it, or choose another {option}")
        yield


@contextmanager
def locked(path: Path) -> Iterator[bool]:
    """Hold a lock file, unless another process does; give whether no other does, as far as the file system can tell."""
    lock = FileLock(path, timeout=0)
    with suppress(NotImplementedError):  # some file systems have no locks
        try:
            lock.acquire()
        except Timeout:
            yield False
            return
    try:
        yield True
    finally:
        if lock.is_locked:
            path.unlink(missing_ok=True)
            lock.release()


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Give a path to write to that becomes ``path`` at the end; when writing fails, ``path`` stays as it was.

    What is written is a file, or a folder where there is none yet. A link stays, and its target is replaced. A pipe or
    a device stays and is written to at the end. Several processes may write one path: the last one counts.
    """
    if _is_special(path):
        with tempfile.TemporaryDirectory(prefix="indoor-explorers-") as folder:
            partial = Path(folder, path.name)
            yield partial
            with partial.open("rb") as written, path.open("wb") as special:
                shutil.copyfileobj(written, special)
        return
    path = Path(os.path.realpath(path))
    partial = path.with_name(f".{path.name}.{uuid4().hex[:12]}.partial")
    try:
        yield partial
        partial.replace(path)
    except OSError as error:
        if error.filename == str(partial):
            error.filename = str(path)
        raise
    finally:
        if partial.is_dir():
            shutil.rmtree(partial)
        else:
            partial.unlink(missing_ok=True)


def write_whole(path: Path, text: str) -> None:
    """Write a text file as :func:`written_whole` does, in UTF-8 with the line ends of ``text``."""
    with written_whole(path) as partial:
        partial.write_text(text, encoding="utf-8", newline="\n")


def _is_special(path: Path) -> bool:
    """Tell whether a path is neither file nor folder; raises ``OSError`` for circular links."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return False
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))
