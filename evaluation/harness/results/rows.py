"""The tables of a store and their rows: compressing records and maps, reading them, and the checksum of a row."""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping
from dataclasses import replace
from hashlib import sha256
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.evaluation.harness.episodes.record import FlownEpisode, Outcome, Record
from indoor_explorers.evaluation.harness.episodes.steps import Steps
from indoor_explorers.evaluation.harness.experiment.experiment import Task

Row = tuple[Any, ...]

#: The tables of every store.
SCHEMA = """
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL) STRICT;
CREATE TABLE run (id INTEGER PRIMARY KEY, facts TEXT NOT NULL, experiment TEXT NOT NULL) STRICT;
CREATE TABLE policy (name TEXT PRIMARY KEY, position INTEGER NOT NULL, facts TEXT NOT NULL) STRICT;
CREATE TABLE scenario (
    name TEXT PRIMARY KEY, position INTEGER NOT NULL, fingerprint TEXT NOT NULL, facts TEXT NOT NULL
) STRICT;
CREATE TABLE floorplan (
    digest TEXT PRIMARY KEY, name TEXT NOT NULL, height INTEGER NOT NULL, width INTEGER NOT NULL,
    resolution REAL, kept REAL NOT NULL, cells BLOB NOT NULL, start_row INTEGER, start_column INTEGER
) STRICT;
CREATE TABLE episode (
    policy TEXT NOT NULL REFERENCES policy (name), scenario TEXT NOT NULL REFERENCES scenario (name),
    map_index INTEGER NOT NULL, seed INTEGER NOT NULL, run INTEGER NOT NULL REFERENCES run (id),
    floorplan TEXT NOT NULL REFERENCES floorplan (digest), team INTEGER NOT NULL, budget INTEGER NOT NULL,
    reachable INTEGER NOT NULL, outcome TEXT NOT NULL, reason TEXT NOT NULL, steps INTEGER NOT NULL,
    metrics TEXT NOT NULL, covered BLOB NOT NULL, cells BLOB NOT NULL, actions BLOB NOT NULL,
    seconds BLOB NOT NULL, sent BLOB NOT NULL,
    PRIMARY KEY (policy, scenario, map_index, seed)
) STRICT;
"""
#: All tables that a store may have, each after those that refer to it.
TABLES = ("damaged", "episode", "attempt", "floorplan", "origin", "scenario", "policy", "run", "checksum", "meta")
#: The digests of all rows.
CHECKSUMS = "CREATE TABLE checksum (digest BLOB PRIMARY KEY) STRICT, WITHOUT ROWID"
#: Attempts at an episode that do not count, each with how it ended; added to older stores too.
ATTEMPTS = """
CREATE TABLE IF NOT EXISTS attempt (
    policy TEXT NOT NULL, scenario TEXT NOT NULL, map_index INTEGER NOT NULL, seed INTEGER NOT NULL,
    outcome TEXT NOT NULL, reason TEXT NOT NULL, steps INTEGER NOT NULL
) STRICT
"""
#: Source and kind of each map by its digest; added to older stores when they are flown on.
ORIGINS = """
CREATE TABLE IF NOT EXISTS origin (floorplan TEXT PRIMARY KEY, source TEXT NOT NULL, kind TEXT NOT NULL) STRICT
"""


def checksum(table: str, row: Row) -> bytes:
    """Return a hash of a row of a table, as SQLite returns it."""
    parts = [value if type(value) is bytes else str(value).encode("utf-8", "surrogateescape") for value in row]
    return sha256(b"\0".join((table.encode(), *parts))).digest()[:16]


def compressed(array: NDArray[Any]) -> bytes:
    """Return the compressed bytes of an array."""
    return zlib.compress(np.ascontiguousarray(array).tobytes(), 6)


def decompressed(blob: bytes, kind: type, *shape: int) -> NDArray[Any]:
    """Return the array that :func:`compressed` was given."""
    return np.frombuffer(zlib.decompress(blob), kind).reshape(shape)


def floorplan_row(plan: Floorplan) -> Row:
    """Return the row of a map; its height is that of a level, its cells are those of the plane of all levels."""
    start, size = plan.start or (None, None), (plan.levels.height, plan.levels.width)
    return (plan.digest, plan.name, *size, plan.resolution, plan.kept, compressed(plan.truth), *start)


def floorplan_of(row: Row) -> Floorplan:
    """Return the map of a row.

    Raises:
        ValueError: the row is damaged.

    """
    digest, name, height, width, resolution, kept, cells, row_index, column = row
    start = None if row_index is None else (row_index, column)
    plane = decompressed(cells, np.uint8, -1, width)
    levels = (len(plane) + 1) // max(1, height + 1)
    plan = Floorplan(plane, name, resolution, kept, start, level_count=levels)
    for added in range(_solid_on_top(plan) + 1):
        if (same := replace(plan, added=added)).digest == digest:
            return same
    raise ValueError("its cells are not those of its hash")


def _solid_on_top(plan: Floorplan) -> int:
    """Return how many levels on top of a map are solid; some of them may have been added to the source's."""
    free = (plan.levels.volume(plan.truth) == FREE).any(axis=(1, 2))
    return int(np.argmax(free[::-1]))


def episode_row(record: FlownEpisode, run: int, floorplan: str) -> Row:
    """Return the row of an episode; ``floorplan`` is the digest of its map."""
    return (
        *(record.policy, *record.task, run, floorplan, record.team, record.budget, record.reachable),
        *(str(record.outcome), record.reason, record.steps, json.dumps(record.metrics)),
        compressed(record.covered.astype(np.int32)),
        compressed(record.cells.astype(np.int16)),
        compressed(record.actions.astype(np.uint8)),
        compressed(record.seconds.astype(np.float32)),
        compressed(record.sent.astype(np.int64)),
    )


def steps_of(row: Row) -> Steps:
    """Return the steps of an episode's row; raises one of several errors where the row is damaged."""
    team, steps, (covered, cells, actions, seconds, sent) = row[6], row[11], row[13:]
    return Steps(
        covered=decompressed(covered, np.int32, steps + 1, -1),
        cells=decompressed(cells, np.int16, steps + 1, team, 2),
        actions=decompressed(actions, np.uint8, steps, team),
        seconds=decompressed(seconds, np.float32, steps + 1),
        sent=decompressed(sent, np.int64, steps + 1),
    )


def fields_of(row: Row, plans: Mapping[str, Floorplan]) -> dict[str, Any]:
    """Return the fields of the record of an episode's row without its steps; raises as :func:`steps_of` does."""
    policy, scenario, index, seed, _, plan, team, budget, reachable, outcome, reason, _, metrics, *_ = row
    return {
        **{"policy": policy, "task": Task(scenario, index, seed), "floorplan": plans[plan]},
        **{"team": team, "budget": budget, "reachable": reachable},
        **{"outcome": Outcome(outcome), "reason": reason, "metrics": json.loads(metrics)},
    }


def record_of(row: Row, plans: Mapping[str, Floorplan]) -> Record:
    """Return the record of an episode's row with its steps; raises as :func:`steps_of` does."""
    return Record(**fields_of(row, plans), **vars(steps_of(row)))
