"""A store whose writer keeps the digests of its rows in this process, where no policy can change them."""

from __future__ import annotations

import json
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from indoor_explorers.env.errors import one_line
from indoor_explorers.evaluation.harness.episodes.record import Outcome, Record
from indoor_explorers.evaluation.harness.experiment.experiment import Task, episode_name
from indoor_explorers.evaluation.harness.results.database import transaction
from indoor_explorers.evaluation.harness.results.reading import StoreReader
from indoor_explorers.evaluation.harness.results.rows import Row, checksum, floorplan_of, record_of

#: A row by its table and rowid.
Place = tuple[str, int]


class StoredFlight(NamedTuple):
    """An episode by its row, with the facts by which some are chosen from many."""

    rowid: int
    map_index: int
    actions: bytes
    """Compressed."""


class WrittenRows(StoreReader):
    """Finds rows that other programs changed; reads single episodes, and moves them to the table of damaged ones."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._noted: dict[Place, bytes] = {}
        """The digests of rows as they were found when the run began, or were written since."""

    def changed(self, run: int) -> dict[Place, str]:
        """Return rows that are not as they were noted, and episodes of a run of this process that it did not write.

        The values are descriptions of the rows as they are now.
        """
        of_run = self._rows(f"SELECT rowid FROM episode WHERE run = {run}")
        digests = dict.fromkeys((("episode", rowid) for (rowid,) in of_run), b"") | self._noted
        now = ((place, self._row(*place), digest) for place, digest in digests.items())
        return {
            place: _named(place[0], row)
            for place, row, digest in now
            if row is None or checksum(place[0], row) != digest
        }

    def flights(self, policy: str, scenario: str) -> list[StoredFlight]:
        """Return the episodes of a policy that did not fail, in the order in which they were added."""
        which = "policy = ? AND scenario = ? AND outcome <> ? ORDER BY rowid"
        query = f"SELECT rowid, map_index, actions FROM episode WHERE {which}"
        return [StoredFlight(*row) for row in self._db.execute(query, (policy, scenario, Outcome.FAILED))]

    def rows_of(self, runs: Sequence[int]) -> list[int]:
        """Return the rows of all episodes of some runs."""
        return [
            rowid for (rowid,) in self._rows(f"SELECT rowid FROM episode WHERE run IN ({', '.join(map(str, runs))})")
        ]

    def all_runs(self) -> dict[int, dict[str, Any]]:
        """Return the facts of each run by its number."""
        return {
            number: self._facts(facts, f"run {number}") for number, facts in self._rows("SELECT id, facts FROM run")
        }

    def records_at(self, rowids: Sequence[int]) -> list[Record]:
        """Return episodes by their rows."""
        rows = [row for rowid in rowids if (row := self._row("episode", rowid)) is not None]
        maps = "SELECT floorplan.* FROM floorplan, json_each(?) WHERE digest = value"
        with self._understood("an episode"):
            found = self._db.execute(maps, (json.dumps([row[5] for row in rows]),))
            plans = {row[0]: floorplan_of(row) for row in found}
            return [record_of(row, plans) for row in rows]

    def set_aside(self, rowids: Collection[int]) -> None:
        """Move episodes to a table of their own, so that they are flown again."""
        with transaction(self._db, self.path):
            self._move_aside(rowids)

    def _move_aside(self, rowids: Collection[int]) -> None:
        if rowids:
            rows = [(rowid,) for rowid in rowids]
            self._db.execute("CREATE TABLE IF NOT EXISTS damaged AS SELECT * FROM episode WHERE false")
            self._db.executemany("INSERT INTO damaged SELECT * FROM episode WHERE rowid = ?", rows)
            self._db.executemany("DELETE FROM episode WHERE rowid = ?", rows)

    def _note(self, table: str, which: str = "true", *values: Any) -> list[bytes]:
        """Note some rows of a table as they are, all by default; return their digests."""
        rows = self._db.execute(f"SELECT rowid, * FROM {table} WHERE {which}", values)
        noted = {(table, rowid): checksum(table, tuple(row)) for rowid, *row in rows}
        self._noted |= noted
        return list(noted.values())

    def _row(self, table: str, rowid: int) -> Row | None:
        return next(iter(self._rows(f"SELECT * FROM {table} WHERE rowid = {rowid}")), None)


def _named(table: str, row: Row | None) -> str:
    if row is None:
        return f"a row of table {table} that is missing"
    if table != "episode":
        return f"a row of table {table}"
    return one_line(episode_name(row[0], Task(*row[1:4])))
