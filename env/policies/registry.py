"""Names to policies: declared names, ``NAME:PATH`` for trained policies, or ``module:Class``.

Policies, the project's own and plug-ins, are declared in the entry-point group ``indoor_explorers.policies``. Openers
are declared in ``indoor_explorers.openers``: they make a policy from a path, such as ``sb3`` in ``sb3:results/ppo``.
Before a colon, the name of an opener hides a module of the same name. A policy's module is imported when the policy
is first made, so torch and ompl load only when they are used.

Only declared objects, which may be functions, and subclasses of :class:`~indoor_explorers.env.policies.policy.Policy`
are ever called.
"""

from __future__ import annotations

import importlib
import inspect
import re
import tomllib
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from numbers import Integral, Real
from operator import attrgetter
from typing import Any, NamedTuple

from indoor_explorers.env.errors import InputError, PolicyError, described, did_you_mean, shown
from indoor_explorers.env.policies.policy import Policy
from indoor_explorers.env.policies.renamed import renamed_parameters

GROUP = "indoor_explorers.policies"
OPENERS = "indoor_explorers.openers"
#: The parts of this package that hold its own policies.
PARTS = ("planners", "learners")
#: The requirement for a name that is not declared.
WANTED = "expected a subclass of indoor_explorers.env.Policy"
#: Which extra of the distribution brings an optional module.
EXTRAS = {
    "torch": "rl",
    "pettingzoo": "marl",
    "stable_baselines3": "sb3",
    "sb3_contrib": "sb3",
    "ray": "ray",
    "pyarrow": "dataset",
}
#: What the values of a parameter are called, and their types, by its annotation.
NUMBERS: Mapping[str, tuple[str, type]] = {
    "bool": ("true or false", bool),
    "int": ("a whole number", Integral),
    "float": ("a number", Real),
}
#: What else to say of a module that is missing.
WITHOUT_WHEELS = {"ompl": "OMPL has wheels for Python up to 3.13, on Linux and on macOS 15 and newer"}


class _Target(NamedTuple):
    """The maker of a policy: ``module:attribute``, the parameters from its name, and whether it is declared."""

    address: str
    given: dict[str, str]
    declared: bool


def policy_entry_points() -> dict[str, EntryPoint]:
    """Return the declared policies by name; raise :class:`InputError` for a name of two different objects."""
    return _declared(GROUP, "policy name")


def opener_entry_points() -> dict[str, EntryPoint]:
    """Return the declared openers of paths by name.

    Raises:
        InputError: a name is declared twice for different objects, or could be part of a module's.

    """
    found = _declared(OPENERS, "opener")
    for name in found:
        if "." in name or ":" in name:
            raise InputError(f"opener {name!r}: expected a name without a dot or colon; ask its owner to rename it")
    return found


def policy_names() -> list[str]:
    """Return the names of all installed policies."""
    return list(policy_entry_points())


def with_parameters(name: str) -> tuple[str, dict[str, Any]]:
    """Return a policy's name and its parameters, which may stand behind it in parentheses: ``pso(length=1)``.

    Parameters are written as in TOML. A name without parentheses has none.

    Raises:
        InputError: what stands in the parentheses are no parameters.

    """
    found = re.fullmatch(r"([^()]+)\((.*)\)", name.strip(), re.DOTALL)
    if found is None:
        return name, {}
    try:
        return found[1].strip(), tomllib.loads(f"given = {{{found[2]}}}")["given"]
    except tomllib.TOMLDecodeError as error:
        raise InputError(
            f"policy {name!r}: expected parameters as in pso(length=1) or dddqn(map_alone=true,guard=false), with "
            f"values as in TOML, got {found[2]!r}"
        ) from error


def make_policy(name: str, **parameters: Any) -> Policy:
    """Make a policy by registry name, ``NAME:PATH`` or ``module:Class``, with parameters for its constructor.

    Raises:
        InputError: no such name, a missing optional dependency, or parameters it does not take.
        PolicyError: its module or its constructor raises something else.

    """
    kind, given = _load(name)
    _refuse_unknown(name, kind, parameters)
    _refuse_mistyped(name, kind, parameters)
    try:
        policy = kind(**given, **parameters)
    except TypeError as error:
        raise InputError(f"policy {name!r} cannot be made: {error}") from error
    except InputError:
        raise
    except (Exception, SystemExit) as error:
        raise PolicyError(f"policy {name!r} cannot be made: {described(error)}") from error
    if not isinstance(policy, Policy):
        raise InputError(f"policy {name!r}: {WANTED}, got {type(policy).__name__}")
    return policy


def policy_class(name: str) -> Any:
    """Return the class or function that :func:`make_policy` calls; raise :class:`InputError` if there is none."""
    return _load(name)[0]


def _refuse_unknown(name: str, kind: Any, parameters: Mapping[str, Any]) -> None:
    """Refuse an unknown parameter of a constructor, and suggest the likely one."""
    try:
        known = inspect.signature(kind).parameters
    except (TypeError, ValueError):  # built-in ones tell nothing; the call itself will
        return
    if any(each.kind is inspect.Parameter.VAR_KEYWORD for each in known.values()):
        return
    for parameter in parameters:
        if parameter not in known and parameter not in renamed_parameters(kind):
            hint = did_you_mean(parameter, known)
            raise InputError(f"policy {name!r} cannot be made: unknown parameter {parameter!r}{hint}")


def _refuse_mistyped(name: str, kind: Any, parameters: Mapping[str, Any]) -> None:
    """Refuse a value where a dataclass declares a bool or a number, and it is none."""
    declared = fields(kind) if isinstance(kind, type) and is_dataclass(kind) else ()
    for field in declared:
        annotation = getattr(field.type, "__name__", str(field.type)).removesuffix(" | None")
        if field.name not in parameters or annotation not in NUMBERS:
            continue
        value, (wanted, types) = parameters[field.name], NUMBERS[annotation]
        missing = value is None and field.default is None
        if not missing and (isinstance(value, bool) != (types is bool) or not isinstance(value, types)):
            raise InputError(f"policy {name!r}: expected {field.name} to be {wanted}, got {shown(value)}")


def missing_module(error: ModuleNotFoundError) -> str:
    """Return which module is not installed, and the extra of this package, or the systems, that have it."""
    module = (error.name or "").partition(".")[0]
    where = f"install indoor-explorers[{EXTRAS[module]}]" if module in EXTRAS else WITHOUT_WHEELS.get(module)
    return f"no module named {error.name!r}" + (f"; {where}" if where else "")


def _declared(group: str, what: str) -> dict[str, EntryPoint]:
    """Return the entry points of a group by name, in order."""
    found: dict[str, list[EntryPoint]] = defaultdict(list)
    for entry in entry_points(group=group):
        if all(entry.value != other.value for other in found[entry.name]):
            found[entry.name].append(entry)
    for name, entries in found.items():
        if len(entries) > 1:
            owners = " and ".join(f"{entry.value} of {entry.dist.name if entry.dist else '?'}" for entry in entries)
            raise InputError(f"{what} {name!r} is declared twice, by {owners}; rename or uninstall one")
    return {name: found[name][0] for name in sorted(found)}


@cache
def is_own_policy(name: str) -> bool:
    """Tell, without an import, whether a policy belongs to this package; raise :class:`InputError` if there is none."""
    package, _, rest = _target(name).address.partition(".")
    return package == __name__.partition(".")[0] and rest.partition(".")[0] in PARTS


def _load(name: str) -> tuple[Any, dict[str, str]]:
    """Return the maker of a policy, and the parameters from its name."""
    target = _target(name)
    kind = _found(name, target.address)
    if not target.declared and not (isinstance(kind, type) and issubclass(kind, Policy)):
        what = "class" if isinstance(kind, type) else type(kind).__name__
        raise InputError(f"policy {name!r}: {WANTED}, got the {what} {target.address}; nothing was called")
    return kind, target.given


def _target(name: str) -> _Target:
    """Return the maker of a policy, without importing anything."""
    known = policy_entry_points()
    before, colon, path = name.partition(":")
    if not colon and name in known:
        return _Target(known[name].value, {}, declared=True)
    openers = opener_entry_points()
    if before not in openers:
        if not colon:
            raise InputError(f"unknown policy {name!r}{did_you_mean(name, {*known, *openers})}")
        return _Target(name, {}, declared=False)
    if not path:
        raise InputError(f"policy {name!r}: expected {before}:PATH, got no path")
    return _Target(openers[before].value, {"path": path}, declared=True)


def _found(name: str, target: str) -> Any:
    """Return the object at ``module:attribute``."""
    module_name, _, attribute = target.partition(":")
    module = _imported(name, module_name)
    try:
        return attrgetter(attribute)(module)
    except AttributeError as error:
        raise InputError(f"policy {name!r}: module {module_name} has no {attribute!r}") from error


def _imported(name: str, module_name: str) -> Any:
    if not module_name or module_name.startswith("."):
        raise InputError(f"policy {name!r}: expected module:Class, got no full module name before the colon")
    try:
        return importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        raise InputError(f"policy {name!r}: {missing_module(error)}") from error
    except InputError:
        raise
    except (Exception, SystemExit) as error:
        raise PolicyError(f"policy {name!r}: importing {module_name} raised {described(error)}") from error
