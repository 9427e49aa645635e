"""The process of a peer: published code of another group, run by the interpreter of an environment made for it.

Such code often needs packages that do not go with this one's, such as numpy before version 2. So it runs in a process
of its own, by the interpreter that the user names, in the folder of the user's clone. A script that comes with this
package drives it there (:mod:`.child`) and answers questions from here, in messages of :mod:`.wire`.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import subprocess
import time
import weakref
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from indoor_explorers.env.errors import InputError, RunError, one_line
from indoor_explorers.env.files import expanded
from indoor_explorers.planners.toolbox.peers import wire

#: Seconds that the interpreter may take to start.
START_LIMIT = 120.0
#: Seconds that a process whose output has ended may take to end.
SHUTDOWN_GRACE = 2.0
#: Bytes that are read at once, and those kept of what the peer printed last.
CHUNK, KEPT = 1 << 18, 4000
#: Characters and lines of what the peer printed last that an error repeats.
TAIL, TAIL_LINES = 400, 3
#: One thread, no files in the clone, no window.
SETTINGS = {
    **dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"),
    **{"PYTHONDONTWRITEBYTECODE": "1", "MPLBACKEND": "Agg"},
}
#: Settings of this interpreter that the peer's must not inherit.
OURS = ("PYTHONPATH", "PYTHONHOME", "PYTHONSAFEPATH", "PYTHONWARNINGS", "PYTHONSTARTUP", "VIRTUAL_ENV")


class PeerFailure(RunError):
    """Report a process of a peer that died, hung, failed or sent what is no answer; it has been ended."""


@dataclass(frozen=True, kw_only=True)
class Need:
    """A package that the code of a peer imports."""

    package: str
    """Its name in the package index."""
    module: str = ""
    """The name it is imported by; empty if that is the same."""
    below: int | None = None
    """The first major version that does not do."""

    @property
    def requirement(self) -> str:
        """The requirement for pip."""
        return self.package if self.below is None else f"{self.package}<{self.below}"

    def met_by(self, version: str | None) -> bool:
        """Return whether a version does; None if the package is missing, empty if its version is unknown."""
        major = (version or "").partition(".")[0]
        return version is not None and not (self.below and major.isdecimal() and int(major) >= self.below)


@dataclass(frozen=True, kw_only=True)
class Peer:
    """How the process of a peer is started."""

    interpreter: str | Path
    """The Python interpreter of an environment that was made by the peer's instructions."""
    folder: Path
    """The clone, which is the working folder of the process."""
    script: Path
    """The file whose functions answer. It may import what the clone and its environment have, never this package."""
    needs: tuple[Need, ...] = ()
    """The packages that are checked at the start."""
    time_limit: float = 60.0
    """Seconds that an answer may take."""


class PeerProcess:
    """Ask the process of a peer; it is started when first asked, and anew after it failed.

    So a peer that dies costs only the episode in which it does. Use it as a context, or close it; its process ends
    with this one in any case, and so do the processes that it started in its group. Not for several threads at once.
    """

    def __init__(self, peer: Peer) -> None:
        self.peer = peer
        self.python: str | None = None
        """The version of the peer's Python, None before the first start."""
        self.versions: dict[str, str | None] = {}
        """The versions of its packages."""
        self._running: _Running | None = None

    def __enter__(self) -> PeerProcess:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def start(self) -> None:
        """Start the process if there is none, and check its packages.

        Raises:
            InputError: the interpreter does not start, or lacks a package.

        """
        if self._running is not None:
            return
        self._running = _Running(self.peer)
        with self._closed_on_error():
            try:
                told = self._running.answer(START_LIMIT)
                self.python, self.versions = str(told["python"]), dict(told["versions"])
            except (PeerFailure, KeyError, TypeError, ValueError) as error:
                what = f"expected a Python interpreter, of version 3.8 or newer, got {error}"
                raise InputError(f"{self.peer.interpreter}: {what}; give the one of the peer's environment") from error
            for need in self.peer.needs:
                if not need.met_by(version := self.versions.get(need.package)):
                    raise self._unmet(need.requirement, f"{need.package} {version}" if version else "none")

    def ask(self, question: str, /, **values: Any) -> dict[str, Any]:
        """Return what a function of the script returns for some keyword arguments, all JSON values and arrays.

        Raises:
            InputError: the interpreter does not start, or lacks a package.
            PeerFailure: there was no answer within the time limit, or none that can be used.

        """
        self.start()
        assert self._running is not None
        with self._closed_on_error():
            told = self._running.answer(self.peer.time_limit, wire.packed({"ask": question, "values": values}))
            if missing := told.get("missing"):
                package = next((n.package for n in self.peer.needs if n.module == missing), str(missing).split(".")[0])
                raise self._unmet(package, f"no module {missing!r}")
            if not isinstance(answer := told.get("answer"), dict):
                raise PeerFailure(f"{self._running.name} failed in {question!r}: {told.get('failed', 'no answer')}")
            return answer

    def close(self) -> None:
        """End the process and those that it started."""
        if self._running is not None:
            self._running.end()
            self._running = None

    def _unmet(self, requirement: str, found: str) -> InputError:
        python = self.peer.interpreter
        return InputError(
            f"{python}: expected {requirement!r} for {self.peer.folder}, found {found}; "
            f"run `{python} -m pip install '{requirement}'`"
        )

    @contextlib.contextmanager
    def _closed_on_error(self) -> Iterator[None]:
        try:
            yield
        except BaseException:
            self.close()
            raise


class _Running:
    """A process that runs, with its three pipes, none of which ever blocks."""

    def __init__(self, peer: Peer) -> None:
        self.name = f"the process of {peer.folder.name}"
        self._unsent, self._read, self._printed = b"", bytearray(), bytearray()
        needs = [f"{need.module or need.package}={need.package}" for need in peer.needs]
        child = Path(__file__).with_name("child.py")
        try:
            self._process = subprocess.Popen(
                [_command(peer.interpreter), child, peer.script.absolute(), *needs],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                cwd=peer.folder,
                env={name: value for name, value in os.environ.items() if name not in OURS} | SETTINGS,
                start_new_session=True,
            )
        except OSError as error:
            what = f"expected a Python interpreter, cannot start it: {error.strerror or error}"
            raise InputError(f"{peer.interpreter}: {what}; give the one of the peer's environment") from error
        pipes = (self._process.stdin, self._process.stdout, self._process.stderr)
        self._in, self._out, self._err = (pipe.fileno() for pipe in pipes if pipe)
        for pipe in (self._in, self._out, self._err):
            os.set_blocking(pipe, False)
        self.end = weakref.finalize(self, _end, self._process)

    def answer(self, limit: float, message: bytes = b"") -> dict[str, Any]:
        """Send a message and return the answer, within ``limit`` seconds.

        Raises:
            PeerFailure: there is none.

        """
        until = time.monotonic() + limit
        self._unsent = message
        while (answer := self._message()) is None:
            if (left := until - time.monotonic()) <= 0:
                raise self._failure(f"gave no answer within {limit:g} s")
            self._transfer(left)
        return answer

    def _transfer(self, seconds: float) -> None:
        """Wait until a pipe is ready, and write and read what is possible."""
        poll = select.poll()
        for pipe in (self._out, self._err):
            poll.register(pipe, select.POLLIN)
        if self._unsent:
            poll.register(self._in, select.POLLOUT)
        for pipe, _ in poll.poll(1000 * seconds):
            if pipe == self._in:
                self._write()
            elif pipe == self._err:
                self._note_printed()
            elif chunk := os.read(pipe, CHUNK):
                self._read += chunk
            else:
                raise self._failure(self._death())

    def _write(self) -> None:
        try:
            self._unsent = self._unsent[os.write(self._in, self._unsent[:CHUNK]) :]
        except BlockingIOError:
            pass
        except BrokenPipeError:
            self._unsent = b""  # the end of its output tells why

    def _note_printed(self) -> bool:
        """Keep the end of what it printed; return whether there was more."""
        with contextlib.suppress(BlockingIOError):
            chunk = os.read(self._err, CHUNK)
            self._printed = (self._printed + chunk)[-KEPT:]
            return bool(chunk)
        return False

    def _message(self) -> dict[str, Any] | None:
        """Return the answer if it is complete."""
        begins = wire.PREFIX.size
        if len(self._read) < begins:
            return None
        try:
            head, body = wire.lengths(bytes(self._read[:begins]))
            if len(self._read) < begins + head + body:
                return None
            if len(self._read) > begins + head + body:
                raise ValueError("expected one answer, got more")
            whole, self._read = bytes(self._read), bytearray()
            return wire.unpacked(whole[begins : begins + head], whole[begins + head :])
        except ValueError as error:
            raise self._failure(f"sent what is no answer: {error}") from error

    def _death(self) -> str:
        """Say how it ended."""
        try:
            code = self._process.wait(SHUTDOWN_GRACE)
        except subprocess.TimeoutExpired:
            return "closed its output"
        if code >= 0:
            return f"ended with exit code {code}"
        return f"was killed by {signal.Signals(-code).name if -code in set(signal.Signals) else f'signal {-code}'}"

    def _failure(self, what: str) -> PeerFailure:
        while self._note_printed():
            pass
        lines = self._printed.decode(errors="replace").strip().splitlines()[-TAIL_LINES:]
        tail = one_line(" | ".join(line.strip() for line in lines)[-TAIL:])
        return PeerFailure(f"{self.name} {what}" + (f"; it printed: {tail}" if tail else ""))


def _command(interpreter: str | Path) -> str:
    """Return an interpreter as a command that works in any folder; links stay, as those of environments have to."""
    path = expanded(interpreter)
    return str(path.absolute() if len(path.parts) > 1 else path)


def _end(process: subprocess.Popen[bytes]) -> None:
    """Kill a process with its group, and close its pipes."""
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    for pipe in (process.stdin, process.stdout, process.stderr):
        assert pipe is not None
        with contextlib.suppress(BrokenPipeError):
            pipe.close()
