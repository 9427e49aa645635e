"""Results of the conformance suite: violations of the contract, and the finding of each check."""

from __future__ import annotations

import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from indoor_explorers.env.errors import SHOWN as SHOWN
from indoor_explorers.env.errors import PolicyError, described
from indoor_explorers.env.errors import shown as shown

#: The folder of this package; the line in which a plug-in raised an error is searched outside of it.
_OURS = Path(__file__).parents[1]


class Violation(PolicyError):
    """Report one violation of the contract: what was found, and the likely cause with the way to fix it."""

    def __init__(self, found: str, fix: str) -> None:
        super().__init__(f"{found}; {fix}")
        self.found = found
        self.fix = fix


class CannotFly(Violation):
    """Report a violation after which an episode cannot go on, such as an error raised by the policy."""


class Differs(Violation):
    """Report choices that should have been the same."""


class Finding(NamedTuple):
    """The result of one check."""

    name: str
    """Name of the check."""
    passed: bool
    """Whether the policy passed."""
    text: str
    """A short description."""
    seconds: float
    """Duration of the check, including its episodes."""
    error: Violation | None = None
    """The violation; None for a check that passed."""
    conclusive: bool = True
    """False for a check without a result: an earlier finding explains its failure, or it cannot be run."""

    @property
    def fix(self) -> str:
        """The likely cause of a failure and the way to fix it; empty for a check that passed."""
        return self.error.fix if self.error is not None and self.conclusive else ""


@contextmanager
def calling(what: str) -> Iterator[None]:
    """Turn any error of a plug-in into :class:`CannotFly`; ``what`` names the code that was called."""
    try:
        yield
    except (Exception, SystemExit) as error:
        found = f"{what} raised {described(error, SHOWN)}"
        if "read-only" in described(error):
            raise CannotFly(found, "views are read-only, copy what you change") from error
        raise CannotFly(found, _where(error)) from error


def _where(error: BaseException) -> str:
    """Return the innermost line in a plug-in's own folder at which it raised an error."""
    frames = [
        frame for frame in traceback.extract_tb(error.__traceback__) if not Path(frame.filename).is_relative_to(_OURS)
    ]
    if not frames:
        return "give it the arguments that indoor_explorers.env.Policy and Pilot have"
    home = Path(frames[0].filename).parent
    place = [frame for frame in frames if Path(frame.filename).is_relative_to(home)][-1]
    return f"see {Path(place.filename).name}, line {place.lineno}, in {place.name}"
