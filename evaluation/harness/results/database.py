"""The SQLite file of a store: opening, transactions, and how errors name damage; other processes may use it too."""

from __future__ import annotations

import resource
import sqlite3
import time
import zlib
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import NamedTuple

from indoor_explorers.env import InputError
from indoor_explorers.env.errors import RunError, one_line
from indoor_explorers.evaluation.harness.experiment.experiment import Task

#: Errors of reading a damaged row.
UNREADABLE = (ValueError, KeyError, TypeError, AttributeError, OverflowError, MemoryError, RecursionError, zlib.error)
#: The way out where a store cannot be mended.
REPLACE = "replace it by a copy, or use another folder"
NO_CHECKSUM = "it does not match its checksum"
#: Errors of reading a database; SQLite's messages may quote damaged text that is no UTF-8.
SQL_ERRORS = (sqlite3.Error, UnicodeDecodeError)
#: Seconds to wait for another process that writes.
PATIENCE = 60.0


def connect(address: str) -> sqlite3.Connection:
    """Open a database by its URI."""
    return sqlite3.connect(address, timeout=PATIENCE, isolation_level=None, uri=True, check_same_thread=False)


def connect_read_only(path: Path) -> sqlite3.Connection:
    """Open a store for reading.

    A store that no process has open has no file of changes beside it: it is read as it is. So no file is made, which
    a read-only folder would not allow, and which another user could not write to later.
    """
    changes = (path.with_name(path.name + ending) for ending in ("-wal", "-journal"))
    quiet = not any(file.exists() and file.stat().st_size for file in changes)
    return connect(f"{path.resolve().as_uri()}?mode=ro{'&immutable=1' if quiet else ''}")


class Damage(NamedTuple):
    """A damaged episode."""

    rowid: int
    policy: str
    task: Task
    why: str

    def __str__(self) -> str:
        """Name the episode and what is wrong with it."""
        scenario, index, seed = self.task
        return f"policy {self.policy!r}, scenario {scenario!r}, map {index}, seed {seed}: {self.why}"


def damaged(path: Path, what: object, remedy: str = REPLACE) -> InputError:
    """Return the error that a store is damaged."""
    return InputError(f"{path} is damaged: {one_line(str(what))}; {remedy}")


def damaged_episodes(path: Path, found: Sequence[Damage]) -> InputError:
    """Return the error that some episodes of a store are damaged."""
    what = f"episode of {found[0]}" if len(found) == 1 else f"{len(found)} episodes, first of {found[0]}"
    return damaged(path, what, f"the same compare command flies what is damaged again, or {REPLACE}")


@contextmanager
def transaction(db: sqlite3.Connection, path: Path) -> Iterator[None]:
    """Write everything in the block or nothing.

    Raises:
        RunError: the disk is full, the file cannot be written for another reason, or another program has emptied it.

    """
    try:
        with db:
            db.execute("BEGIN IMMEDIATE")
            yield
    except sqlite3.OperationalError as error:
        raise not_written(path, error) from error
    except (sqlite3.DatabaseError, UnicodeDecodeError) as error:
        if getattr(error, "sqlite_errorcode", 0) == sqlite3.SQLITE_CONSTRAINT_FOREIGNKEY:
            raise RunError(
                f"{path}: another program has removed what this run had written, as compare --fresh does; "
                "run it again, with another folder if both are wanted"
            ) from error
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
