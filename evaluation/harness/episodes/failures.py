"""Describes the exception of a policy: the reason of a failed episode."""

from __future__ import annotations

import sysconfig
import traceback
from pathlib import Path

from indoor_explorers.env import InputError
from indoor_explorers.env.errors import PolicyError, debugging, described, one_line
from indoor_explorers.evaluation.harness.episodes.shared_memory import DecisionTimeout

#: Exceptions of a policy that fail its episode; Ctrl-C does not.
BREAKING = (Exception, SystemExit, DecisionTimeout)
#: Folders of the code that calls policies, and that of Python itself.
_OURS = {Path(__file__).parents[3] / floor for floor in ("env", "evaluation")}
_STDLIB = Path(sysconfig.get_path("stdlib"))


def describe_error(error: BaseException) -> str:
    """Return the type, message and place of a policy's exception as one short line that can be printed.

    Where errors are debugged, the traceback goes to the standard error.
    """
    if debugging():
        traceback.print_exception(error)
    text = one_line(str(error)) if isinstance(error, DecisionTimeout) else described(error)
    place = one_line(_place(error))
    return text + (place and f" ({place})")


def _place(error: BaseException) -> str:
    """Return where a policy raised and which of its functions was called first; empty if it did not raise.

    That is its own code, or a library's where none of its own was running.
    """
    if isinstance(error, DecisionTimeout):  # anywhere
        return ""
    cause = error.__cause__ if isinstance(error, (InputError, PolicyError)) else None
    trace = traceback.extract_tb((cause or error).__traceback__)
    frames = [frame for frame in trace if not _OURS.intersection(_folders(frame)) and "importlib" not in frame.filename]
    own = [frame for frame in frames if "site-packages" not in frame.filename and _STDLIB not in _folders(frame)]
    places = [f"{Path(frame.filename).name}:{frame.lineno} in {frame.name}" for frame in own or frames[-1:]]
    return ", from ".join([*places[-1:], *places[:-1][:1]])


def _folders(frame: traceback.FrameSummary) -> set[Path]:
    return set(Path(frame.filename).parents)
