"""Names to policies: the entry-point group ``indoor_explorers.policies``, or ``module:Class``.

The project's own policies are declared in the same group as anybody else's. Nothing is imported before
it is asked for, so torch and ompl load only when they are used.
"""

from __future__ import annotations

import importlib
from collections import defaultdict
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from indoor_explorers.env.errors import InputError, PolicyError, did_you_mean
from indoor_explorers.env.policy import Policy

GROUP = "indoor_explorers.policies"


def policy_entry_points() -> dict[str, EntryPoint]:
    """Return the declared policies by name; a name declared twice is refused.

    Raises:
        InputError: two installed distributions declare the same name for different objects.

    """
    found: dict[str, list[EntryPoint]] = defaultdict(list)
    for entry in entry_points(group=GROUP):
        if all(entry.value != other.value for other in found[entry.name]):
            found[entry.name].append(entry)
    for name, entries in found.items():
        if len(entries) > 1:
            owners = " and ".join(f"{entry.value} of {entry.dist.name if entry.dist else '?'}" for entry in entries)
            raise InputError(f"policy name {name!r} is declared twice, by {owners}; rename or uninstall one")
    return {name: found[name][0] for name in sorted(found)}


def policy_names() -> list[str]:
    """Return the names of all installed policies."""
    return list(policy_entry_points())


def make_policy(name: str, **parameters: Any) -> Policy:
    """Make a policy by registry name or ``module:Class``, with parameters for its constructor.

    Raises:
        InputError: no such name, a missing optional dependency, or parameters it does not take.
        PolicyError: its module or its constructor raises something else.

    """
    kind = _load(name)
    try:
        policy = kind(**parameters)
    except TypeError as error:
        raise InputError(f"policy {name!r} cannot be made: {error}") from error
    except InputError:
        raise
    except (Exception, SystemExit) as error:
        raise PolicyError(f"policy {name!r} cannot be made: {type(error).__name__}: {error}") from error
    if not isinstance(policy, Policy):
        raise InputError(
            f"policy {name!r}: expected a subclass of indoor_explorers.env.Policy, got {type(policy).__name__}"
        )
    return policy


def _load(name: str) -> Any:
    if ":" not in name:
        known = policy_entry_points()
        if name not in known:
            raise InputError(f"unknown policy {name!r}{did_you_mean(name, known)}")
        name, target = known[name].name, known[name].value
    else:
        target = name
    module_name, _, attribute = target.partition(":")
    found = _imported(name, module_name)
    try:
        for part in attribute.split("."):
            found = getattr(found, part)
    except AttributeError as error:
        raise InputError(f"policy {name!r}: module {module_name} has no {attribute!r}") from error
    return found


def _imported(name: str, module_name: str) -> Any:
    if not module_name or module_name.startswith("."):
        raise InputError(f"policy {name!r}: expected module:Class, got no full module name before the colon")
    try:
        return importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        extra = "; install indoor-explorers[rl]" if error.name in {"torch", "safetensors"} else ""
        raise InputError(f"policy {name!r}: no module named {error.name!r}{extra}") from error
    except (Exception, SystemExit) as error:
        raise PolicyError(f"policy {name!r}: importing {module_name} raised {type(error).__name__}: {error}") from error
