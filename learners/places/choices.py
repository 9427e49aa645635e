"""The choices of training flights as arrays, in memory and in files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.planners.toolbox.networks.tensors import read_tensors, write_tensors

Arrays = Mapping[str, NDArray[Any]]


class Flown(NamedTuple):
    """A training flight."""

    choices: list[dict[str, NDArray[Any]]]
    """Arrays of each UAV's choices: see :func:`~indoor_explorers.learners.places.flights.as_arrays`."""
    times: tuple[float, float]
    """Steps to 90 % and 99 % of the reachable cells, in units of these cells by the lidar's range; NaN for teams."""


class Choices(NamedTuple):
    """C choices, in the order of flights, UAVs and time."""

    arrays: Arrays
    """Arrays (C, ...) by name: see :func:`~indoor_explorers.learners.places.flights.as_arrays`."""
    lengths: NDArray[np.int64]
    """(U,) number of choices of each UAV."""
    flight: NDArray[np.int64]
    """(U,) number of its flight."""
    times: NDArray[np.float64]
    """(F, 2) times of each flight, see :class:`Flown`."""

    @property
    def half(self) -> NDArray[np.int64]:
        """(C,) 0 or 1: the half of the flights that a choice belongs to."""
        return np.asarray(np.repeat(self.flight % 2, self.lengths))


def choices_of(flights: Sequence[Flown]) -> Choices:
    """Return the choices of some flights, at least one."""
    uavs = [uav for flight in flights for uav in flight.choices]
    arrays = {name: np.concatenate([uav[name] for uav in uavs]) for name in uavs[0]}
    lengths = np.array([len(uav["chosen"]) for uav in uavs], np.int64)
    numbers = np.repeat(np.arange(len(flights)), [len(flight.choices) for flight in flights])
    return Choices(arrays, lengths, numbers, np.array([flight.times for flight in flights], np.float64))


def write_choices(path: Path, choices: Choices) -> None:
    """Write choices to a file of arrays."""
    about = {"uav.lengths": choices.lengths, "uav.flight": choices.flight, "flight.times": choices.times}
    write_tensors(path, {**choices.arrays, **about})


def read_choices(paths: Sequence[Path]) -> Choices:
    """Return the choices of some files, one after the other."""
    parts = [read_tensors(path)[0] for path in paths]
    whole = {name: np.concatenate([part[name] for part in parts]) for name in parts[0] if name != "uav.flight"}
    first = np.cumsum([0, *(len(part["flight.times"]) for part in parts)])
    numbers = np.concatenate([part["uav.flight"] + before for part, before in zip(parts, first[:-1], strict=True)])
    lengths, times = whole.pop("uav.lengths"), whole.pop("flight.times")
    return Choices(whole, lengths, numbers, times)
