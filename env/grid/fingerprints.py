"""A hash of everything that a compiled function depends on, transitively: its code and the names in it.

Two functions of equal fingerprints compile to the same machine code. File names, line numbers, docstrings and comments
do not count.
"""

from __future__ import annotations

import enum
import hashlib
import inspect
from collections.abc import Iterator
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numba

from indoor_explorers.env.grid.numba_parts import Dispatcher

#: numba's types, half of whose attributes are not declared.
types: Any = numba.types

#: Packages whose versions are part of the cache's key; their contents are not hashed.
_VERSIONED = ("numpy", "numba", "math", "builtins", "llvmlite")

_known: dict[FunctionType, str] = {}
_open: list[FunctionType] = []


def fingerprint(function: FunctionType) -> str:
    """Return the hash of a function, of its constants and of all functions that it calls, as 64 hex digits."""
    if function in _open:  # it calls itself
        return f"{len(_open) - _open.index(function)} up"
    if function not in _known:
        _open.append(function)
        try:
            text = "\n".join(_facts_of(function))
        finally:
            _open.pop()
        _known[function] = hashlib.sha256(text.encode()).hexdigest()
    return _known[function]


def type_key(kind: Any) -> str:
    """Return a text that identifies a numba type, including the fields of named tuples and structs."""
    if isinstance(kind, types.BaseNamedTuple):
        made_of = kind.instance_class
        return f"{made_of.__module__}.{made_of.__qualname__}({_pairs(zip(kind.fields, kind, strict=True))})"
    if isinstance(kind, types.StructRef):
        return f"{type(kind).__module__}.{type(kind).__qualname__}({_pairs(kind.field_dict.items())})"
    if isinstance(kind, types.BaseTuple):
        return f"({', '.join(type_key(part) for part in kind.types)})"
    if isinstance(kind, types.Dispatcher):
        return f"function {fingerprint(kind.dispatcher.py_func)}"
    return str(kind)


def _pairs(fields: Any) -> str:
    return ", ".join(f"{name}={type_key(kind)}" for name, kind in fields)


def _facts_of(function: FunctionType) -> Iterator[str]:
    """Yield lines that describe a function."""
    yield f"{function.__module__}.{function.__qualname__} {function.__defaults__!r}"
    yield from _facts_of_code(function.__code__, function.__doc__)
    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    known = function.__globals__ | {name: cell.cell_contents for name, cell in cells}
    for name in sorted(_names(function.__code__) & set(known)):
        yield f"{name}: {_describe(known[name])}"


def _facts_of_code(code: CodeType, docstring: str | None) -> Iterator[str]:
    yield repr((code.co_code, code.co_names, code.co_varnames, code.co_freevars, code.co_argcount, code.co_flags))
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _facts_of_code(constant, None)
        elif docstring is None or constant != docstring:
            yield repr(constant)


def _names(code: CodeType) -> set[str]:
    """Return the names that a function and its inner functions may look up among their globals."""
    inside = [_names(constant) for constant in code.co_consts if isinstance(constant, CodeType)]
    return set(code.co_names).union(code.co_freevars, *inside)


def _describe(value: Any) -> str:
    """Return a text that is equal for equal values of a global name."""
    if isinstance(value, Dispatcher):
        options = sorted((key, repr(option)) for key, option in value.targetoptions.items())
        return f"compiled {options} {fingerprint(value.py_func)}"
    if isinstance(value, FunctionType):
        return fingerprint(value) if not _is_versioned(value.__module__) else f"{value.__module__}.{value.__qualname__}"
    if isinstance(value, ModuleType):
        return value.__name__ if _is_versioned(value.__name__) else _source(value)
    if isinstance(value, type):
        return _describe_class(value)
    if hasattr(value, "dtype") and hasattr(value, "tobytes"):
        return f"{value.dtype} {value.shape} {value.tobytes().hex()}"
    if isinstance(value, enum.Enum):
        return f"{_describe_class(type(value))} {value.name}"
    if value is None or isinstance(value, str | bytes | bool | int | float | complex | tuple | frozenset):
        return repr(value)
    return str(value) if isinstance(value, types.Type) else f"{type(value).__module__}.{type(value).__qualname__}"


def _describe_class(kind: type) -> str:
    name = f"{kind.__module__}.{kind.__qualname__}"
    if _is_versioned(kind.__module__):
        return name
    if issubclass(kind, enum.Enum):
        return f"{name} {[(member.name, member.value) for member in kind]!r}"
    if issubclass(kind, tuple) and hasattr(kind, "_fields"):
        return f"{name} {kind._fields!r} {getattr(kind, '_field_defaults', None)!r}"
    return f"{name} {_source(kind)}"


def _source(value: Any) -> str:
    try:
        return hashlib.sha256(inspect.getsource(value).encode()).hexdigest()
    except (OSError, TypeError):
        return repr(getattr(value, "__version__", None))


def _is_versioned(module: str | None) -> bool:
    return (module or "").partition(".")[0] in _VERSIONED
