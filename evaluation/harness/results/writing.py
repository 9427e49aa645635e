"""Writes to SQLite files of which other processes may read and write, and which may be damaged."""

from __future__ import annotations

import resource
import sqlite3
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from indoor_explorers.env.errors import RunError, one_line
from indoor_explorers.evaluation.harness.results.damage import damaged
from indoor_explorers.evaluation.harness.results.reading import PATIENCE, connect


@contextmanager
def transaction(db: sqlite3.Connection, path: Path) -> Iterator[None]:
    """Write everything in the block or nothing.

    Raises:
        RunError: the disk is full, or the file cannot be written for another reason.

    """
    try:
        with db:
            db.execute("BEGIN IMMEDIATE")
            yield
    except sqlite3.OperationalError as error:
        raise not_written(path, error) from error
    except (sqlite3.DatabaseError, UnicodeDecodeError) as error:
        raise damaged(path, error) from error


def not_written(path: Path, error: Exception) -> RunError:
    """Return the error to raise where SQLite could not write."""
    limit, _ = resource.getrlimit(resource.RLIMIT_FSIZE)
    cause = "" if limit == resource.RLIM_INFINITY else f"raise the limit of {limit} bytes a file (ulimit -f), or "
    return RunError(
        f"{path} cannot be written: {one_line(str(error))}; the finished episodes are kept: {cause}make room on the "
        "disk, and the same command goes on from there"
    )


def write_ahead(db: sqlite3.Connection) -> None:
    """Set the journal mode in which readers do not wait; SQLite itself does not wait for others who do the same."""
    until = time.monotonic() + PATIENCE
    while True:
        try:
            db.execute("PRAGMA journal_mode = WAL")
        except sqlite3.OperationalError as error:
            if error.sqlite_errorcode != sqlite3.SQLITE_BUSY or time.monotonic() > until:
                raise
            time.sleep(0.01)
        else:
            return


def is_corrupt(path: Path) -> bool:
    """Tell whether a file is an SQLite database whose structure is damaged; other kinds of files are not."""
    try:
        with closing(connect(path.resolve().as_uri())) as db:
            return bool(db.execute("PRAGMA integrity_check(1)").fetchone() != ("ok",))
    except sqlite3.Error as error:
        return getattr(error, "sqlite_errorcode", 0) & 0xFF == sqlite3.SQLITE_CORRUPT
    except UnicodeDecodeError:
        return True


def remove(path: Path) -> None:
    """Delete a database with the files of changes beside it."""
    for ending in ("", "-wal", "-shm"):
        path.with_name(path.name + ending).unlink(missing_ok=True)
