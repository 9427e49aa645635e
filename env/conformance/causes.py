"""Look for the likely cause of a difference between episodes that should be the same."""

from __future__ import annotations

import random
import sys
from collections.abc import Iterator
from types import FunctionType

import numpy as np

from indoor_explorers.env.policies.policy import Pilot, Policy

_CONTAINERS = (list, dict, set, bytearray, np.ndarray, np.random.Generator, random.Random)


def global_generators() -> dict[str, str]:
    """Return the state of the global random generators, to detect later whether a policy drew from one."""
    return {
        "random": repr(random.getstate()),
        "numpy.random": repr(np.random.get_state(legacy=False)),  # noqa: NPY002 - to find those who draw from it
    }


def shared_things(policy: Policy, pilot: type) -> str:
    """Name what pilots can share through the policy, a class, a default argument or a module; empty when nothing."""
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
