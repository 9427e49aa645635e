"""A world's arrays and constants bound into one object for compiled code.

Passing some fifty arrays from Python to numba takes longer than a step of the world; a structref passes one pointer.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import types
from numba.experimental import structref
from numpy.typing import NDArray

from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.sensing.lidar import LidarModel, Scan, new_scan
from indoor_explorers.env.simulation.state import Rules, State

#: Parts of numba that carry no types.
_unliteral: Any = types.unliteral
_define_proxy: Any = structref.define_proxy


class Work(NamedTuple):
    """Working arrays of a step, not to be shared between threads."""

    scan: Scan
    order: NDArray[np.int64]
    """(N,) agents in the order in which they move."""
    component: NDArray[np.int64]
    """(N,) see :func:`indoor_explorers.env.simulation.radio.link`."""
    before: NDArray[np.int64]
    """(N,) lengths of the discovery logs before an exchange."""


class ExactParts(NamedTuple):
    """The arguments of the compiled functions of a step without errors."""

    rules: Rules
    state: State
    work: Work


@kernel()
def new_work(lidar: LidarModel, team: int) -> Work:
    """Allocate the working arrays of steps."""
    return Work(new_scan(lidar), np.empty(team, np.int64), np.empty(team, np.int64), np.empty(team, np.int64))


@structref.register
class _EngineType(types.StructRef):
    """numba's type of :class:`Engine`."""

    def preprocess_fields(self, fields: Any) -> Any:
        return tuple((name, _unliteral(kind)) for name, kind in fields)


class Engine(structref.StructRefProxy):
    """One thread's arguments to step a world; made by :func:`bind`, and read by compiled code alone."""

    rules: Rules
    state: State
    lidar: LidarModel
    work: Work


_define_proxy(Engine, _EngineType, ["rules", "state", "lidar", "work"])

_new: Any = Engine


@kernel()
def bind(rules: Rules, state: State, lidar: LidarModel, work: Work) -> Engine:
    """Bind a world's parts for one thread; the arrays are shared, not copied."""
    engine: Engine = _new(rules, state, lidar, work)
    return engine
