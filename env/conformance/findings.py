"""Results of the conformance suite: violations of the contract, their likely causes, and the finding of each check."""

from __future__ import annotations

import random
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FunctionType
from typing import NamedTuple

import numpy as np

from indoor_explorers.env.errors import SHOWN as SHOWN
from indoor_explorers.env.errors import PolicyError, described
from indoor_explorers.env.errors import shown as shown
from indoor_explorers.env.policies.policy import Pilot, Policy

#: The folder of this package; the line in which a plug-in raised an error is searched outside of it.
_OURS = Path(__file__).parents[1]
#: Mutable types through which pilots may share state.
_CONTAINERS = (list, dict, set, bytearray, np.ndarray, np.random.Generator, random.Random)


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


class Warned(str):
    """The finding of a check that passed, about something that its author should look at."""


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
    warned: bool = False
    """Whether the policy passed with a warning."""

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


def global_generators() -> dict[str, str]:
    """Return the state of the global random generators, to detect later whether a policy drew from one."""
    return {
        "random": repr(random.getstate()),
        "numpy.random": repr(np.random.get_state(legacy=False)),  # noqa: NPY002 - to detect draws from it
    }


def shared_state(policy: Policy, pilot: type) -> str:
    """Name the mutable objects that pilots can share: of the policy, a class, a default argument or a module."""
    found = sorted(set(_of_policy(policy)) | {name for kind in (type(policy), pilot) for name in _of_class(kind)})
    return f"; perhaps {', '.join(found[:3])}" if found else ""


def _of_policy(policy: Policy) -> Iterator[str]:
    for name, value in getattr(policy, "__dict__", {}).items():
        if isinstance(value, _CONTAINERS):
            yield f"the {type(value).__name__} {name} of the policy"


def _of_class(kind: type) -> Iterator[str]:
    """Name the mutable attributes of a class and of its module, and the mutable defaults of its methods."""
    for owner in kind.__mro__:
        if owner in (Pilot, Policy, object) or owner.__module__.startswith("indoor_explorers.env"):
            continue
        for name, value in vars(owner).items():
            if isinstance(value, _CONTAINERS) and not name.startswith("__"):
                yield f"the {type(value).__name__} {owner.__name__}.{name}"
            if isinstance(value, FunctionType) and any(isinstance(x, _CONTAINERS) for x in value.__defaults__ or ()):
                yield f"a default argument of {owner.__name__}.{name}"
        for name, value in vars(sys.modules.get(owner.__module__, object)).items():
            if isinstance(value, _CONTAINERS) and not name.startswith("__") and not name.isupper():
                yield f"the {type(value).__name__} {name} of the module"
