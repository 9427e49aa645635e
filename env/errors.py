"""The project's exception types; each message is one line that says how to fix the input."""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterable

#: Characters that are kept of a policy's error message.
LONGEST = 500
#: Characters of a value, or of a plug-in's error, that are repeated in a message.
SHOWN = 120
#: Characters of an error's line and of a word in it, such as a path; of a longer word, those kept on both sides.
LONGEST_LINE, LONGEST_WORD, WORD_HEAD, WORD_TAIL = 2000, 400, 200, 80


class _OneLineError(Exception):
    """An error whose message is made one printable line, whatever file names and values are in it."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message, LONGEST_LINE))


class InputError(_OneLineError, ValueError):
    """Report input of a user that cannot be used.

    The message is one line: what was expected, what was received and how to fix it. The command line
    prints it as it is and exits with status 2.
    """


class PolicyError(Exception):
    """Report a policy that breaks the contract of :mod:`indoor_explorers.env.policies.policy`."""


class RunError(_OneLineError, RuntimeError):
    """Report a run that failed for another reason than its input, such as a killed worker."""


def debugging() -> bool:
    """Return whether errors are shown with their traceback."""
    return bool(os.environ.get("INDOOR_EXPLORERS_DEBUG"))


def did_you_mean(word: str, known: Iterable[str], prefix: str = "") -> str:
    """Return ``"; did you mean 'x'?"`` for the closest known word, else the list of known words.

    ``prefix`` comes before the words in a dotted key, such as ``"radio."``.
    """
    names = sorted(known)
    close = difflib.get_close_matches(word, names, n=1, cutoff=0.6)
    if close:
        return f"; did you mean {prefix + close[0]!r}?"
    return f"; known: {', '.join(prefix + name for name in names) or 'none'}"


def one_line(text: str, most: int = LONGEST) -> str:
    """Return a text as one printable line of at most ``most`` characters; very long words lose their middle."""
    flat = " ".join(map(_cut, text[: 10 * most].split()))
    shown = "".join(each if each.isprintable() else each.encode("unicode_escape").decode() for each in flat)
    return shown if len(shown) <= most else shown[: most - 1] + "…"


def _cut(word: str) -> str:
    return word if len(word) <= LONGEST_WORD else f"{word[:WORD_HEAD]}…{word[-WORD_TAIL:]}"


def shown(value: object, most: int = SHOWN) -> str:
    """Return the ``repr`` of a value on one line, or a description if its ``repr`` fails."""
    try:
        return one_line(repr(value), most)
    except Exception as error:
        return f"a {type(value).__name__} whose repr raises {type(error).__name__}"


def described(error: BaseException, most: int = LONGEST) -> str:
    """Return the type and message of an exception as one line, even if its ``str`` fails."""
    try:
        text = str(error)
    except BaseException as worse:
        text = f"its message raised {type(worse).__name__}"
    return one_line(f"{type(error).__name__}: {text}", most)
