"""How this project compiles: numba decorators with one set of options each.

``kernel`` compiles once and keeps the machine code beside the source. ``leaf`` does the same for functions
that allocate nothing: without numba's reference counts of arrays, which cost more than most of these
functions do, and which the arrays' owner, who calls, makes unnecessary. A leaf may call leaves only.
``inner`` is a leaf that compiled code alone may call, as it has no entry from Python, which would take longer to
compile than the function itself; a call from Python would crash.
"""

from __future__ import annotations

from functools import partial

from numba import njit

kernel = partial(njit, cache=True, nogil=True, no_cfunc_wrapper=True)
leaf = partial(kernel, error_model="numpy", _nrt=False)
inner = partial(leaf, no_cpython_wrapper=True)
