"""Records whose steps stay in the store until they are used, and are then read, checked and unpacked.

An episode then takes about a kilobyte of memory instead of some tens. The steps that were read last are kept, as most
reports use them several times.
"""

from __future__ import annotations

import sqlite3
import struct
import weakref
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import fields
from functools import cached_property, lru_cache, partial
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.episodes.steps import StepFacts, Steps
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.database import (
    NO_CHECKSUM,
    UNREADABLE,
    Damage,
    connect_read_only,
    damaged_episodes,
)
from indoor_explorers.evaluation.harness.results.rows import Row, checksum, fields_of, steps_of

#: Bytes of unpacked steps that are kept.
KEPT = 2**23
#: Fields of a record that are read when they are asked for.
OF_STEPS = tuple(each.name for each in fields(Steps))
Metrics = dict[str, float | None]


class StoredSteps:
    """The steps of the episodes in a store, which is opened for the first of them."""

    def __init__(self, path: Path) -> None:
        self._path = path.resolve()
        self._kept: OrderedDict[int, Steps] = OrderedDict()
        self._bytes = 0

    @cached_property
    def _db(self) -> sqlite3.Connection:
        db = connect_read_only(self._path)
        weakref.finalize(self, db.close)
        return db

    def read(self, rowid: int) -> Steps:
        """Return the steps of an episode.

        Raises:
            InputError: they cannot be read, or changed since the store was read.

        """
        found = self._kept.get(rowid)
        if found is None:
            found = self._kept[rowid] = self._unpacked(rowid)
            self._bytes += found.size
            while self._bytes > KEPT and len(self._kept) > 1:
                self._bytes -= self._kept.popitem(last=False)[1].size
        else:
            self._kept.move_to_end(rowid)
        return found

    def _unpacked(self, rowid: int) -> Steps:
        row: Row = (None,) * 4
        try:
            row = self._db.execute("SELECT * FROM episode WHERE rowid = ?", (rowid,)).fetchone() or row
            digest = checksum("episode", row)
            if not self._db.execute("SELECT 1 FROM checksum WHERE digest = ?", (digest,)).fetchone():
                raise ValueError(NO_CHECKSUM)
            return steps_of(row)
        except (sqlite3.Error, *UNREADABLE) as error:
            raise damaged_episodes(self._path, [Damage(rowid, row[0], Task(*row[1:4]), str(error))]) from error


class StoredRecord(Record):
    """A record whose steps are in a store; with other fields (``replace``) it is one in memory."""

    _source: StoredSteps
    _rowid: int
    _length: int
    _layout: MetricLayout
    _numbers: bytes
    _facts: StepFacts

    @classmethod
    def of_row(cls, row: Row, rowid: int, plans: Mapping[str, Floorplan], source: StoredSteps) -> Self:
        """Return the record of an episode's row; raises one of several errors where the row is damaged."""
        held = fields_of(row, plans)
        held |= _metric_attributes(held.pop("metrics")) | {"_source": source, "_rowid": rowid, "_length": row[11]}
        return cls._with(held)

    @classmethod
    def _with(cls, attributes: Mapping[str, Any]) -> Self:
        record = object.__new__(cls)
        for name, value in attributes.items():
            object.__setattr__(record, name, value)
        return record

    def __getattr__(self, name: str) -> Any:
        """Return a field that is read from the store or unpacked on demand."""
        if name in OF_STEPS:
            return getattr(self._read(), name)
        if name == "metrics":
            return self._layout.unpack(self._numbers)
        if name == "_length":
            return len(self.actions)
        if name == "_facts":
            object.__setattr__(self, "_facts", self._read().facts)
            return self._facts
        raise AttributeError(name)

    def _read(self) -> Steps:
        return self._source.read(self._rowid)

    @property
    def steps(self) -> int:
        """How many steps were flown."""
        return self._length

    @property
    def distance(self) -> NDArray[np.int64]:
        """(S + 1,) cells flown by all UAVs together up to each step."""
        return self._read().distance

    @property
    def facts(self) -> StepFacts:
        """What is kept of the steps once they have been read."""
        return self._facts

    def with_metrics(self, metrics: Metrics) -> Self:
        """Return the record with other metrics."""
        kept = {name: value for name, value in vars(self).items() if name not in ("metrics", "_layout", "_numbers")}
        return self._with(kept | _metric_attributes(metrics))

    def __reduce__(self) -> tuple[Any, ...]:
        """Leave the store behind: a copy is in memory."""
        return partial(Record, **{each.name: getattr(self, each.name) for each in fields(Record)}), ()


class MetricLayout(NamedTuple):
    """Names and types of the metrics that episodes have in common."""

    numbers: struct.Struct
    valued: tuple[str, ...]
    missing: Metrics
    """All names in their order, as if none had a value."""

    def unpack(self, numbers: bytes) -> Metrics:
        """Return the metrics."""
        return {**self.missing, **dict(zip(self.valued, self.numbers.unpack(numbers), strict=True))}


@lru_cache(maxsize=1024)
def _layout(names: tuple[str, ...], kinds: tuple[type, ...]) -> MetricLayout:
    codes = {float: "d", int: "q", type(None): ""}
    valued = tuple(name for name, kind in zip(names, kinds, strict=True) if kind is not type(None))
    return MetricLayout(struct.Struct("=" + "".join(codes[kind] for kind in kinds)), valued, dict.fromkeys(names))


def _metric_attributes(metrics: Metrics) -> dict[str, Any]:
    """Return metrics as attributes of a record: as bytes, or unchanged where they are not plain numbers."""
    try:
        layout = _layout(tuple(metrics), tuple(map(type, metrics.values())))
        numbers = layout.numbers.pack(*(value for value in metrics.values() if value is not None))
    except (KeyError, struct.error):
        return {"metrics": metrics}
    return {"_layout": layout, "_numbers": numbers}
