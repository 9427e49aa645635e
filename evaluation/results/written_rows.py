"""A store whose writer remembers what it wrote: digests stay in this process, where no policy can change them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from indoor_explorers.env.errors import one_line
from indoor_explorers.evaluation.episodes.record import Outcome, Record
from indoor_explorers.evaluation.results.reading import StoreReader
from indoor_explorers.evaluation.results.rows import Row, checksum, record_of
from indoor_explorers.evaluation.results.writing import transaction

#: A row by its table and rowid.
Place = tuple[str, int]


class Flight(NamedTuple):
    """An episode by its row, with what it is chosen by from many."""

    rowid: int
    map_index: int
    actions: bytes
    """Packed."""


class WrittenRows(StoreReader):
    """Tells which rows are not what this process wrote; reads and sets aside single episodes."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._written: dict[Place, bytes] = {}
        """The digests of what was written."""

    def changed(self, run: int) -> dict[Place, str]:
        """Return rows that are not as this process wrote them, and episodes of its run that it did not write.

        Each is named by what it is now.
        """
        of_run = self._rows(f"SELECT rowid FROM episode WHERE run = {run}")
        digests = dict.fromkeys((("episode", rowid) for (rowid,) in of_run), b"") | self._written
        now = ((place, self._row(*place), digest) for place, digest in digests.items())
        return {
            place: _named(place[0], row)
            for place, row, digest in now
            if row is None or checksum(place[0], row) != digest
        }

    def flights(self, policy: str, scenario: str) -> list[Flight]:
        """Return the episodes of a policy that did not fail, in the order in which they were added."""
        which = "policy = ? AND scenario = ? AND outcome <> ? ORDER BY rowid"
        query = f"SELECT rowid, map_index, actions FROM episode WHERE {which}"
        return [Flight(*row) for row in self._db.execute(query, (policy, scenario, Outcome.FAILED))]

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
        plans = self._maps()
        return [record_of(row, plans) for rowid in rowids if (row := self._row("episode", rowid)) is not None]

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

    def _row(self, table: str, rowid: int) -> Row | None:
        return next(iter(self._rows(f"SELECT * FROM {table} WHERE rowid = {rowid}")), None)


def _named(table: str, row: Row | None) -> str:
    if row is None:
        return f"a row of table {table} that is missing"
    if table != "episode":
        return f"a row of table {table}"
    policy, scenario, index, seed, *_ = row
    return one_line(f"{policy} on {scenario}, map {index}, seed {seed}")
