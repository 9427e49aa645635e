"""Metrics of plug-ins: worked out from the records of results, stored ones too."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from indoor_explorers.env import InputError
from indoor_explorers.env.errors import described
from indoor_explorers.env.plugins import load_plugin
from indoor_explorers.evaluation.harness.episodes.metrics import MEASURES, Measure
from indoor_explorers.evaluation.harness.episodes.record import Record

if TYPE_CHECKING:
    from indoor_explorers.evaluation.harness.results.results import Results

#: The entry-point group of metrics.
METRICS = "indoor_explorers.metrics"


@dataclass(frozen=True, kw_only=True)
class Metric(Measure):
    """A metric of an episode.

    Declared in the entry-point group ``indoor_explorers.metrics``, or named as ``module:NAME``; its key in tables is
    the declared name, or NAME.
    """

    value: Callable[[Record], float | None]
    """Returns the value of an episode; None where it has none."""


def with_metrics(results: Results, names: Sequence[str]) -> Results:
    """Return results with the metrics of these names in their records and tables.

    Raises:
        InputError: a metric cannot be loaded, has the key of another one, or fails.

    """
    found = dict(_named(names))
    if not found:
        return results
    records = [
        record.with_metrics({**record.metrics, **{key: _value(key, each, record) for key, each in found.items()}})
        for record in results.records
    ]
    return replace(results, records=records, custom_measures={**results.custom_measures, **found})


def _named(names: Sequence[str]) -> Iterator[tuple[str, Metric]]:
    taken = set(MEASURES)
    for name in names:
        metric, key = load_plugin(METRICS, name, "metric"), name.rpartition(":")[2]
        if not isinstance(metric, Metric):
            raise InputError(f"metric {name!r}: expected a Metric, got {type(metric).__name__}")
        if key in taken or key.startswith("pilot_"):
            raise InputError(f"metric {name!r}: expected a key of its own, got {key!r}, which is taken; rename it")
        taken.add(key)
        yield key, metric


def _value(key: str, metric: Metric, record: Record) -> float | None:
    try:
        value = metric.value(record)
    except Exception as error:
        raise InputError(
            f"metric {key!r} failed on {record.policy}, {tuple(record.task)}: {described(error)}"
        ) from error
    if value is None:
        return None
    number = float(value)
    if not math.isfinite(number):
        raise InputError(f"metric {key!r}: expected a finite number or None, got {number}")
    return number
