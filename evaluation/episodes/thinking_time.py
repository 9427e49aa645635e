"""The clock that decisions are timed with: it stands still while numba compiles, or loads what it compiled before.

Compiling happens once on a machine, loading once in a process; neither is part of what a policy's decisions cost.
"""

from __future__ import annotations

import time
from functools import cache
from typing import Any

from numba.core import event

#: numba has no types for its events.
_TimingListener: Any = event.TimingListener
_register: Any = event.register


def thinking_time() -> float:
    """Return the seconds of a clock that stands still while numba compiles or loads compiled code."""
    timer = _compiler_timer()
    return time.perf_counter() - (timer.duration if timer.done else 0.0)


@cache
def _compiler_timer() -> Any:
    """Return what sums up the seconds for which numba's compiler was locked, in this process, from now on."""
    timer = _TimingListener()
    _register("numba:compiler_lock", timer)
    return timer
