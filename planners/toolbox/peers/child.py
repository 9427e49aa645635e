"""The side of the peer: run by the peer's interpreter, it loads a script whose functions answer questions.

``python child.py SCRIPT MODULE=PACKAGE ...`` runs in the folder of the clone. It needs only Python (3.8 or newer) and
never imports this package; :mod:`~indoor_explorers.planners.toolbox.peers.process` is the other side.

Questions come on the standard input and answers go to the standard output as messages of :mod:`.wire`. The first
answer tells the versions of Python and of the packages. A question names a function of SCRIPT with its keyword
arguments; the function returns a dictionary. What the peer prints goes to the standard error.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
import traceback
from importlib import metadata, util
from pathlib import Path
from types import ModuleType
from typing import Any, BinaryIO

#: Seconds between two checks that the parent is still running.
CHECK_INTERVAL = 0.5


def main(script: str, *needs: str) -> None:
    """Answer questions until the standard input ends; then end the whole group of processes."""
    questions, answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    threading.Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()
    wire = _loaded(Path(__file__).with_name("wire.py"), "_indoor_explorers_wire")
    sys.path[0] = str(Path.cwd())  # in place of the folder of this file
    versions = {need.split("=")[1]: _version(*need.split("=")) for need in needs}
    _send(answers, wire.packed({"python": sys.version.split()[0], "versions": versions}))
    functions: dict[str, Any] = {}
    while (question := _received(questions, wire)) is not None:
        try:
            functions = functions or vars(_loaded(Path(script), "_indoor_explorers_script"))
            message = wire.packed({"answer": functions[question["ask"]](**question["values"])})
        except Exception as error:
            traceback.print_exc()
            missing = error.name if isinstance(error, ModuleNotFoundError) else None
            message = wire.packed({"failed": f"{type(error).__name__}: {error}", "missing": missing})
        _send(answers, message)
    os.killpg(0, signal.SIGKILL)  # with what the peer started


def _loaded(path: Path, name: str) -> ModuleType:
    spec = util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = sys.modules[name] = util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _version(module: str, package: str) -> str | None:
    """Return the version of a package, empty where only its module is found, None where that is missing."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "" if util.find_spec(module) else None


def _received(questions: BinaryIO, wire: Any) -> dict[str, Any] | None:
    """Return the next question, None at the end."""
    prefix = questions.read(wire.PREFIX.size)
    if len(prefix) < wire.PREFIX.size:
        return None
    head, body = wire.lengths(prefix)
    question: dict[str, Any] = wire.unpacked(questions.read(head), questions.read(body))
    return question


def _send(answers: BinaryIO, message: bytes) -> None:
    answers.write(message)
    answers.flush()


def _end_with(parent: int) -> None:
    """Kill this process and those that it started when its parent has ended."""
    while os.getppid() == parent:
        time.sleep(CHECK_INTERVAL)
    os.killpg(0, signal.SIGKILL)


if __name__ == "__main__":
    main(*sys.argv[1:])
