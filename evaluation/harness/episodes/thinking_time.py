"""The clock of decision times: it is stopped while numba compiles, or loads compiled code.

Compiling happens once on a machine and loading once in a process; neither belongs to the cost of a decision.
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
    """Return the seconds of a clock that is stopped while numba compiles or loads compiled code."""
    timer = _compiler_timer()
    return time.perf_counter() - (timer.duration if timer.done else 0.0)


@cache
def _compiler_timer() -> Any:
    """Return a timer of the seconds, from now on, that numba's compiler was busy in this process."""
    timer = _TimingListener()
    _register("numba:compiler_lock", timer)
    return timer
