"""Parameters and attributes that have another name now: the old one is accepted for one minor version, with a warning.

``@renamed(fade="decay_length")`` above a policy's ``@dataclass`` lets its constructor take ``fade`` too. So do the
command line and experiment files, and stored results count as those of the same policy.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from typing import Any, TypeVar

from indoor_explorers.env.errors import InputError

#: The attribute of a class with the present names of parameters by the old one.
ATTRIBUTE = "renamed_parameters"
#: The last minor version that accepts the old names.
LAST_VERSION = "0.3"

#: The end of every advice.
ACCEPTED = f"the old name is accepted up to version {LAST_VERSION}"

T = TypeVar("T")
Names = Mapping[str, tuple[str, ...]]


def renamed(**names: str | tuple[str, ...]) -> Callable[[type[T]], type[T]]:
    """Return a decorator that makes the constructor of a class accept old names of its parameters.

    A subclass that is a dataclass has a constructor of its own: it takes the old names of its base class if it is
    decorated too, if only by ``@renamed()``.

    Args:
        **names: The present name by the old one; several if the value is to go to several parameters.

    """

    def decorate(kind: type[T]) -> type[T]:
        present = {old: (name,) if isinstance(name, str) else name for old, name in names.items()}
        known = {**renamed_parameters(kind), **present}
        construct = kind.__init__

        @wraps(construct)
        def accept(self: T, *args: Any, **given: Any) -> None:
            for old in (name for name in given if name in known):
                warnings.warn(_advice(kind.__name__, old, known[old]), FutureWarning, stacklevel=2)
            construct(self, *args, **with_present_names(given, known, kind.__name__))

        for name, value in (("__init__", accept), (ATTRIBUTE, known)):
            setattr(kind, name, value)
        return kind

    return decorate


def renamed_parameters(kind: Any) -> Names:
    """Return the present names of a class's parameters by the old ones, empty if none was renamed."""
    found: Names = getattr(kind, ATTRIBUTE, {})
    return found


def with_present_names(given: Mapping[str, Any], names: Mapping[str, Sequence[str]], what: str) -> dict[str, Any]:
    """Return the parameters of ``what`` by their present names; raise :class:`InputError` if one is given by both."""
    found = {name: value for name, value in given.items() if name not in names}
    for old in (name for name in given if name in names):
        if twice := [name for name in names[old] if name in found]:
            raise InputError(f"{what}: expected {twice[0]!r} or its old name {old!r}, got both; leave {old!r} out")
        found |= dict.fromkeys(names[old], given[old])
    return found


def _advice(what: str, old: str, names: Sequence[str]) -> str:
    present = " and ".join(map(repr, names))
    return f"{what}: the parameter {old!r} is now {present}; {ACCEPTED}"


def renamed_property(old: str, present: str) -> property:
    """Return a property by an old name, such as ``Navigator.swings``, of the attribute with the ``present`` name.

    A ``__getattr__`` instead would make access to all other attributes of the class slower.
    """

    def read(self: object) -> Any:
        warnings.warn(f"{old} is now {present}; {ACCEPTED}", FutureWarning, stacklevel=2)
        return getattr(self, present)

    return property(read)
