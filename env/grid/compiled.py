"""The project's numba decorators, each with one set of options.

``kernel`` compiles once and keeps the machine code (:mod:`indoor_explorers.env.grid.compile_cache`). ``leaf`` is for
functions that allocate nothing: it omits numba's reference counts of arrays, which cost more than most of these
functions. A leaf may call leaves only. ``inner`` is a leaf without an entry from Python, which is quicker to compile; a
call from Python would crash. If a private part of numba is missing (:mod:`indoor_explorers.env.grid.numba_parts`), all
of them are ``njit(cache=True)``.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from functools import lru_cache
from typing import Any, TypeVar, cast

import numba

from indoor_explorers.env.grid import compile_cache
from indoor_explorers.env.grid.compile_cache import CompileCache
from indoor_explorers.env.grid.numba_parts import MISSING, Dispatcher
from indoor_explorers.env.grid.numba_tuning import widen_literals

#: The environment variable that suppresses the notices of compilation.
QUIET = "INDOOR_EXPLORERS_QUIET"
NOTICE = "indoor-explorers: compiling for this machine, once; this may take half a minute\n"

#: The notice if a private part of numba has changed.
SLOWER = (
    "indoor-explorers: numba {} has changed ({}): compiling takes longer, and compiled code may be slower; results are "
    "the same. After a change of a compiled function remove __pycache__, as numba misses changes of what others call\n"
)
#: Options of njit that are documented.
_DOCUMENTED = ("error_model", "fastmath", "parallel", "inline", "boundscheck")

_njit: Any = numba.njit  # some of its options are left out of its types
Function = TypeVar("Function", bound=Callable[..., Any])


def kernel(*, entry: bool = True, **options: Any) -> Callable[[Function], Function]:
    """Return a decorator that compiles without the interpreter's lock and keeps the machine code.

    Without ``entry`` only compiled code can call the function, and it compiles in a fraction of the time.
    """

    def plain(function: Function) -> Function:
        _warn()
        documented = {name: value for name, value in options.items() if name in _DOCUMENTED}
        return cast(Function, _njit(nogil=True, cache=True, **documented)(function))

    def compiled(function: Function) -> Function:
        dispatcher = _njit(nogil=True, no_cfunc_wrapper=True, no_cpython_wrapper=not entry, **options)(function)
        if isinstance(dispatcher, Dispatcher):  # a plain function when NUMBA_DISABLE_JIT is set
            cast(Any, dispatcher)._cache = CompileCache(cast(Any, function), dispatcher.targetoptions)
            widen_literals(dispatcher)
        return cast(Function, dispatcher)

    return plain if MISSING else compiled


def leaf(*, entry: bool = True) -> Callable[[Function], Function]:
    """Return a decorator for functions that allocate nothing; ``entry`` as in :func:`kernel`."""
    return kernel(entry=entry, error_model="numpy", _nrt=False)


def inner() -> Callable[[Function], Function]:
    """Return a decorator for functions that allocate nothing and are inlined into their compiled callers.

    Passing all arrays of a state, three hundred numbers, costs more than most of these functions. Long functions with
    few arguments are better called: ``leaf(entry=False)``.
    """
    return kernel(entry=False, error_model="numpy", _nrt=False, forceinline=True)


@lru_cache(maxsize=1)
def _warn() -> None:
    if not os.environ.get(QUIET):
        sys.stderr.write(SLOWER.format(numba.__version__, MISSING))


@lru_cache(maxsize=1)
def _announce() -> None:
    """Announce once that functions are being compiled."""
    if not os.environ.get(QUIET):
        sys.stderr.write(NOTICE)


compile_cache.listeners.append(lambda _: _announce())
