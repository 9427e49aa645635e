"""How this project compiles: numba decorators with one set of options each.

``kernel`` compiles once and keeps the machine code beside the source. ``leaf`` does the same for functions
that allocate nothing: without numba's reference counts of arrays, which cost more than most of these
functions do, and which the arrays' owner, who calls, makes unnecessary. A leaf may call leaves only.
``inner`` is a leaf that compiled code alone may call, as it has no entry from Python, which would take longer to
compile than the function itself; a call from Python would crash.

numba keeps machine code until the file of the function changes, but a function also contains the code of those
that it calls, from other files. So the kept code is found again only while no file of the package has changed.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar, cast

from numba import njit
from numba.core.caching import FunctionCache
from numba.core.dispatcher import Dispatcher

#: Set in the environment, this keeps a process from saying so.
QUIET = "INDOOR_EXPLORERS_QUIET"
NOTICE = "indoor-explorers: compiling for this machine, once; this may take half a minute\n"


_njit: Any = njit  # some of its options are left out of its types
_FunctionCache: Any = FunctionCache
Function = TypeVar("Function", bound=Callable[..., Any])


def kernel(**options: Any) -> Callable[[Function], Function]:
    """Return a decorator that compiles without the interpreter's lock and keeps the machine code."""

    def compiled(function: Function) -> Function:
        dispatcher = _njit(nogil=True, no_cfunc_wrapper=True, **options)(function)
        if isinstance(dispatcher, Dispatcher):  # a plain function when NUMBA_DISABLE_JIT is set
            cast(Any, dispatcher)._cache = _Cache(function)
        return cast(Function, dispatcher)

    return compiled


def leaf() -> Callable[[Function], Function]:
    """Return a decorator for functions that allocate nothing."""
    return kernel(error_model="numpy", _nrt=False)


def inner(*, inlined: bool = True) -> Callable[[Function], Function]:
    """Return a decorator for functions that allocate nothing and that Python never calls.

    They become part of their callers unless they are not to be ``inlined``: handing over all the arrays of a state,
    three hundred numbers, costs more than most of them do. Long functions with few arguments are better called.
    """
    return kernel(error_model="numpy", _nrt=False, no_cpython_wrapper=True, forceinline=inlined)


class _Cache(_FunctionCache):  # type: ignore[misc]  # a base class without types
    """Machine code on disk that is valid for the present state of the package's sources."""

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        file = Path(self._py_func.__code__.co_filename)
        return (*super()._index_key(sig, codegen), _stamp(Path(__file__).parents[1]), _stamp(_top(file.parent)))

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            found = super().load_overload(sig, target_context)
        except Exception:  # whatever unpickling raises: half a file, or a name that has moved since it was kept
            self.flush()
            found = None
        if found is None:
            _announce()
        return found


def _top(folder: Path) -> Path:
    """Return the outermost package around a folder."""
    while (folder.parent / "__init__.py").exists():
        folder = folder.parent
    return folder


@lru_cache(maxsize=16)
def _stamp(folder: Path) -> str:
    """Return a hash of the sizes and times of the Python files below a folder."""
    facts = [(str(file.relative_to(folder)), file.stat()) for file in sorted(folder.rglob("*.py"))]
    text = repr([(name, stat.st_size, stat.st_mtime_ns) for name, stat in facts])
    return hashlib.sha256(text.encode()).hexdigest()


@lru_cache(maxsize=1)
def _announce() -> None:
    """Say, once, why nothing seems to happen; worker processes leave it to the one that started them."""
    if not os.environ.get(QUIET):
        sys.stderr.write(NOTICE)
