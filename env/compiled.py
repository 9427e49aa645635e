"""How this project compiles: numba decorators with one set of options.

``kernel`` compiles once and keeps the machine code beside the source. ``leaf`` does the same for functions
that allocate nothing: without numba's reference counts of arrays, which cost more than most of these
functions do, and which the arrays' owner, who calls, makes unnecessary. A leaf may call leaves only.
"""

from __future__ import annotations

from functools import partial

from numba import njit

kernel = partial(njit, cache=True, nogil=True)
leaf = partial(njit, cache=True, nogil=True, error_model="numpy", _nrt=False)
