"""Content-addressed cache of compiled functions on disk.

An entry's key is a hash of the function with all that it calls (:mod:`indoor_explorers.env.grid.fingerprints`), the
types of its arguments, the processor and the versions of Python, numba, numpy and llvmlite. So copies of the project
share entries, and a change recompiles only what depends on it. Processes that need the same function at the same time
compile it once: the others wait.

Entries are in ``NUMBA_CACHE_DIR`` if set, else in the user's cache folder, else in the folder for temporary files.
Entries that no process has used for two months are removed. :class:`CompileCache` replaces the private
``numba.core.caching.FunctionCache``; see :mod:`indoor_explorers.env.grid.numba_parts`.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import pickle
import platform
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from functools import lru_cache
from pathlib import Path
from types import FunctionType
from typing import Any

import llvmlite
import numba
import numpy as np
from filelock import BaseFileLock, FileLock, Timeout
from platformdirs import user_cache_path

from indoor_explorers.env.grid.fingerprints import fingerprint, type_key
from indoor_explorers.env.grid.numba_parts import CompileResult, dumps
from indoor_explorers.env.grid.numba_tuning import install

#: Days after which an entry that no process has used is removed.
KEPT_DAYS = 60
#: Seconds that a process waits for another one to compile the same function, before it does so itself.
PATIENCE = 120.0
_DAY = 24 * 60 * 60

#: Called with a function's name before it is compiled, and with None afterwards.
Listener = Callable[[str | None], None]
listeners: list[Listener] = []


#: Caches of all functions defined in this process.
_caches: list[CompileCache] = []


class CompileCache:
    """The machine code of one function on disk, with the methods that numba's dispatchers call."""

    def __init__(self, function: FunctionType, options: Mapping[str, Any]) -> None:
        self._function = function
        self._options = repr(sorted(options.items()))
        self._waiting: dict[str, BaseFileLock] = {}
        self._enabled = True
        _caches.append(self)

    @property
    def label(self) -> str:
        """Return the function's name and the beginning of its fingerprint, with which names of its entries begin."""
        return f"{self._function.__name__}-{fingerprint(self._function)[:8]}"

    @property
    def cache_path(self) -> str | None:
        """Return the folder that entries lie in, None for none."""
        return None if cache_folder() is None else str(cache_folder())

    def enable(self) -> None:
        """Keep machine code."""
        self._enabled = True

    def disable(self) -> None:
        """Neither find nor keep machine code."""
        self._enabled = False

    def flush(self) -> None:
        """Do nothing: an entry belongs to all functions of its key."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the entry for argument types, or None; numba then compiles and calls :meth:`save_overload`."""
        install()
        target_context.refresh()
        file = self._file(sig, target_context.codegen())
        if file is None:
            _tell(self._function.__qualname__)
            return None
        found = _read(file, target_context)
        if found is None:
            self._wait_for_others(file)
            found = _read(file, target_context)
            if found is None:
                _tell(self._function.__qualname__)
            else:
                self._release(file)
        return found

    def save_overload(self, sig: Any, result: Any) -> None:
        """Write a compiled function to disk; on a full disk or in a read-only folder only the entry is lost."""
        _tell(None)
        file = self._file(sig, result.codegen)
        if file is None:
            return
        with contextlib.suppress(OSError):
            if not result.library.has_dynamic_globals:  # addresses of this process
                write_entry(file, dumps(result._reduce()))
        self._release(file)

    def _file(self, sig: Any, codegen: Any) -> Path | None:
        folder = cache_folder() if self._enabled else None
        if folder is None:
            return None
        arguments = getattr(sig, "args", sig)
        facts = (
            fingerprint(self._function),
            self._options,
            [type_key(kind) for kind in arguments],
            codegen.magic_tuple(),
            _versions(),
        )
        name = hashlib.sha256(repr(facts).encode()).hexdigest()
        return folder / name[:2] / f"{self.label}-{name[2:34]}.nbc"

    def _wait_for_others(self, file: Path) -> None:
        """Wait until no other process compiles this entry, and lock it."""
        if file.name in self._waiting:  # this process tried before, and compiling failed
            return
        lock = FileLock(file.with_suffix(".lock"), timeout=PATIENCE)
        try:
            file.parent.mkdir(exist_ok=True)
            lock.acquire()
        except (OSError, Timeout, NotImplementedError):  # some file systems have no locks
            return
        self._waiting[file.name] = lock

    def _release(self, file: Path) -> None:
        lock = self._waiting.pop(file.name, None)
        if lock is not None:
            lock.release()
            file.with_suffix(".lock").unlink(missing_ok=True)


@lru_cache(maxsize=1)
def cache_folder() -> Path | None:
    """Return the folder for machine code, created if necessary; None if no folder is writeable."""
    asked = os.environ.get("NUMBA_CACHE_DIR")
    wanted = Path(asked) / "indoor-explorers" if asked else user_cache_path("indoor-explorers", appauthor=False)
    shared = Path(tempfile.gettempdir()) / f"indoor-explorers-{_user()}"
    for folder in (wanted / "compiled", shared / "compiled"):
        if _can_keep(folder):
            _remove_old(folder)
            return folder
    return None


def compiling_since(moment: float) -> set[str]:
    """Return the labels of functions that this user's processes compile now and began after ``moment`` (epoch, s)."""
    folder, found = cache_folder(), set()
    for lock in folder.glob("*/*.lock") if folder is not None else ():
        with contextlib.suppress(OSError):  # finished meanwhile
            if lock.stat().st_mtime >= moment:
                found.add(_label(lock))
    return found


def not_compiled() -> set[str]:
    """Return the labels of the functions of this process that have no entry."""
    folder = cache_folder()
    kept = {_label(file) for file in folder.glob("*/*.nbc")} if folder is not None else set()
    return {cache.label for cache in _caches} - kept


def _label(entry: Path) -> str:
    return entry.stem.rpartition("-")[0]


def _user() -> str:
    return str(os.getuid()) if hasattr(os, "getuid") else platform.node()


def _can_keep(folder: Path) -> bool:
    """Tell whether a folder is writeable and belongs to this user, as entries are unpickled."""
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        with tempfile.TemporaryFile(dir=folder):
            pass
        return not hasattr(os, "getuid") or folder.stat().st_uid == os.getuid()
    except OSError:
        return False


def _remove_old(folder: Path) -> None:
    """Remove entries that were not used for :data:`KEPT_DAYS`, at most once a day."""
    mark, now = folder / "last-cleaned", time.time()
    try:
        if mark.exists() and now - mark.stat().st_mtime < _DAY:
            return
        mark.touch()
        for file in folder.glob("*/*"):
            if now - file.stat().st_mtime > KEPT_DAYS * _DAY:
                file.unlink(missing_ok=True)
    except OSError:
        return


def _read(file: Path, target_context: Any) -> Any:
    """Return an entry; None if it is missing, incomplete or refers to names that no longer exist."""
    try:
        data = file.read_bytes()
    except OSError:
        return None
    try:
        found = CompileResult._rebuild(target_context, *pickle.loads(data))
    except Exception:  # whatever unpickling raises
        file.unlink(missing_ok=True)
        return None
    with contextlib.suppress(OSError):
        if time.time() - file.stat().st_mtime > _DAY:
            os.utime(file)  # still in use
    return found


def write_entry(file: Path, data: bytes) -> None:
    """Write an entry atomically."""
    file.parent.mkdir(exist_ok=True)
    handle, partial = tempfile.mkstemp(dir=file.parent, suffix=".partial")
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(data)
        Path(partial).replace(file)
    finally:
        Path(partial).unlink(missing_ok=True)


def _tell(name: str | None) -> None:
    for listener in listeners:
        listener(name)


@lru_cache(maxsize=1)
def _versions() -> tuple[str, ...]:
    return (sys.version, numba.__version__, llvmlite.__version__, np.__version__)
