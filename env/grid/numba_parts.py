"""The private parts of numba that this project uses, imported here alone, and a check that they are as expected.

numba offers no public way to choose the key under which machine code is kept, or when it is optimised. So
:mod:`~indoor_explorers.env.grid.compile_cache` and :mod:`~indoor_explorers.env.grid.numba_tuning` replace parts of it.
If a version of numba has renamed one, :data:`MISSING` names it, and everything is compiled by ``njit(cache=True)``
alone: slower to compile, with the same results.
"""

from __future__ import annotations

import inspect
from typing import Any

#: The attributes used of numba's class for the code of one function.
_LIBRARY = (
    "_optimize_functions",
    "_get_module_for_linking",
    "_finalize_dynamic_globals",
    "_finalize_final_module",
    "_raise_if_finalized",
    "_unserialize",
    "serialize_using_bitcode",
    "serialize_using_object_code",
    "has_dynamic_globals",
)
#: The methods of a cache that dispatchers call, with the names of the arguments.
_CACHE = {
    "cache_path": None,
    "enable": ["self"],
    "disable": ["self"],
    "flush": ["self"],
    "load_overload": ["self", "sig", "target_context"],
    "save_overload": ["self", "sig", "data"],
}
#: Options of njit that are not documented.
_OPTIONS = ("_nrt", "no_cfunc_wrapper", "no_cpython_wrapper", "forceinline")

MISSING = ""
"""The first private part of numba that is not as expected; empty if all are."""
CodeLibrary: Any = object
Codegen: Any = None
CompileResult: Any = None
Dispatcher: Any = None
cpu_target: Any = None
dumps: Any = None
events: Any = None
"""numba's module of events, such as the beginning of a compilation; None where it is not what is expected."""


def _expect(owner: Any, *names: str) -> None:
    for name in names:
        getattr(owner, name)


def _expect_cache(cache: Any) -> None:
    for name, arguments in _CACHE.items():
        found = getattr(cache, name)
        if arguments is not None and list(inspect.signature(found).parameters) != arguments:
            raise AttributeError(f"{cache.__name__}.{name} has other arguments")


try:
    from numba.core import codegen, compiler, cpu, dispatcher, registry, serialize
    from numba.core.caching import FunctionCache

    CodeLibrary, Codegen = codegen.JITCodeLibrary, codegen.JITCPUCodegen
    CompileResult, Dispatcher = compiler.CompileResult, dispatcher.Dispatcher
    cpu_target, dumps = registry.cpu_target, serialize.dumps
    _expect(CodeLibrary, *_LIBRARY)
    _expect(Codegen, "_library_class", "set_env", "magic_tuple", "_module_pass_manager", "_pass_builder")
    _expect(CompileResult, "_reduce", "_rebuild")
    _expect(Dispatcher, "get_call_template", "enable_caching")
    _expect(cpu.CPUTargetOptions, *_OPTIONS)
    _expect_cache(FunctionCache)
except (ImportError, AttributeError) as error:
    MISSING = str(error)

try:
    from numba.core import event

    _expect(event, "register", "Listener", "TimingListener")
    events = event
except (ImportError, AttributeError):
    pass
