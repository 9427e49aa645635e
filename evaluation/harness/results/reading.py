"""Reads a store without changing it: damage is refused in one line.

Every row has its checksum in a table of them; a store from before that table, older than version 0.2.0, is refused.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from indoor_explorers.env import InputError
from indoor_explorers.env.errors import one_line
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.episodes.resimulate import recorded_scenario
from indoor_explorers.evaluation.harness.episodes.stored_names import with_own_models
from indoor_explorers.evaluation.harness.experiment.experiment import Task, merged_experiments
from indoor_explorers.evaluation.harness.results.database import (
    NO_CHECKSUM,
    REPLACE,
    SQL_ERRORS,
    UNREADABLE,
    Damage,
    connect_read_only,
    damaged,
    damaged_episodes,
)
from indoor_explorers.evaluation.harness.results.origins import Origin
from indoor_explorers.evaluation.harness.results.rows import TABLES, Row, checksum, floorplan_of
from indoor_explorers.evaluation.harness.results.stored_record import StoredRecord, StoredSteps

FORMAT = 3
#: The tables that describe the experiment; without them, episodes have no meaning.
SETTINGS = ("meta", "run", "policy", "scenario")
#: Episodes: the rowid, the columns, and the names of policy and scenario, None where these are missing.
EPISODES = (
    "SELECT episode.rowid, episode.*, policy.name, scenario.name FROM episode"
    " LEFT JOIN policy ON policy.name = policy LEFT JOIN scenario ON scenario.name = scenario"
)
#: Their order in results.
ORDER = (
    "SELECT episode.rowid FROM episode"
    " LEFT JOIN policy ON policy.name = policy LEFT JOIN scenario ON scenario.name = scenario"
    " ORDER BY scenario.position, policy.position, map_index, seed"
)
#: Episodes in memory at a time while they are checked.
CHUNK = 256


def _decoded(text: bytes) -> str:
    """Decode a text that may be damaged; different bytes give different texts."""
    return text.decode("utf-8", "surrogateescape")


class StoreReader:
    """The results of one experiment in a file, opened for reading; use as a context manager."""

    def __init__(self, path: Path) -> None:
        self.path = path
        with self._readable():
            self._db = connect_read_only(path)
            self._db.execute("BEGIN")  # all that is read is from one moment
            self._check()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._db.close()

    # -- the experiment -------------------------------------------------------------------------------

    def policies(self) -> dict[str, dict[str, Any]]:
        """Return the facts of each policy by name, in the order of the experiment."""
        rows = self._rows("SELECT name, facts FROM policy ORDER BY position")
        return {name: self._facts(facts, f"policy {name!r}") for name, facts in rows}

    def scenarios(self) -> dict[str, dict[str, Any]]:
        """Return the settings of each scenario by name, ``fingerprint`` included, in order."""
        found = {}
        for name, fingerprint, facts in self._rows("SELECT name, fingerprint, facts FROM scenario ORDER BY position"):
            found[name] = {"fingerprint": fingerprint, **self._facts(facts, f"scenario {name!r}")}
            with self._understood(f"scenario {name!r}"):
                recorded_scenario(with_own_models(found[name]))
                str(found[name]["map"]["source"])  # its maps are looked at later
        return found

    def runs(self) -> list[dict[str, Any]]:
        """Return the facts of each run that an episode is from, oldest first."""
        flown = "SELECT id, facts FROM run WHERE id IN (SELECT run FROM episode) ORDER BY id"
        return [self._facts(facts, f"run {number}") for number, facts in self._rows(flown)]

    def runs_of_episodes(self) -> dict[tuple[str, Task], dict[str, Any]]:
        """Return the facts of the run that flew each episode, by policy and task."""
        facts = {number: self._facts(text, f"run {number}") for number, text in self._rows("SELECT id, facts FROM run")}
        rows = self._rows("SELECT policy, scenario, map_index, seed, run FROM episode")
        return {(policy, Task(*task)): facts[run] for policy, *task, run in rows}

    def experiment(self) -> str:
        """Return one experiment in TOML for all runs, empty without a run."""
        texts = [text for (text,) in self._rows("SELECT experiment FROM run ORDER BY id")]
        with self._understood("the experiment of a run"):
            return merged_experiments(texts)

    # -- episodes -------------------------------------------------------------------------------------

    def records(self) -> list[Record]:
        """Return all episodes, ordered by policy, scenario, map and seed; their steps are read when asked for.

        Raises:
            InputError: some are damaged.

        """
        read = self._episodes()
        if found := [each for each in read if isinstance(each, Damage)]:
            raise damaged_episodes(self.path, found)
        return [each for each in read if isinstance(each, Record)]

    def retries(self) -> dict[tuple[str, Task], int]:
        """Return how often episodes were flown again after a failure, of those that were."""
        if not self._has("attempt"):
            return {}
        rows = self._rows("SELECT policy, scenario, map_index, seed, count(*) FROM attempt GROUP BY 1, 2, 3, 4")
        return {(policy, Task(scenario, index, seed)): count for policy, scenario, index, seed, count in rows}

    def origins(self) -> dict[str, Origin]:
        """Return source and kind of the maps by their digests; of none in stores of older versions."""
        rows = self._rows("SELECT * FROM origin") if self._has("origin") else []
        known = self._checksums() if rows else set()
        return {row[0]: Origin(*row[1:]) for row in rows if checksum("origin", row) in known}

    def notes(self) -> tuple[str, ...]:
        """Return what readers of the results are to know about damaged episodes: a line, or nothing."""
        if not self._has("damaged"):
            return ()
        ((count,),) = self._rows("SELECT count(*) FROM damaged")
        what = "1 damaged episode was" if count == 1 else f"{count} damaged episodes were"
        return (f"{what} set aside, and flown again where a later run asked for it",)

    def _episodes(self) -> list[Record | Damage]:
        """Return all episodes in order; those that cannot be read as damage."""
        plans, known = self._maps(), self._checksums()
        source = StoredSteps(self.path)
        read: dict[int, Record | Damage] = {}
        last = -(2**63)
        while rows := self._rows(f"{EPISODES} WHERE episode.rowid > {last} ORDER BY 1 LIMIT {CHUNK}"):
            last = rows[-1][0]
            read |= {row[0]: _episode(row, plans, known, source) for row in rows}
        return [read[rowid] for (rowid,) in self._rows(ORDER)]

    def _damages(self) -> list[Damage]:
        """Return the damaged episodes; they are not unpacked, as there may be a million."""
        plans, known = self._maps(), self._checksums()
        self._db.text_factory = _decoded
        with self._readable():
            rows = self._db.execute(EPISODES)
            return [_damage(row, why) for row in rows if (why := _complaint(row, plans, known))]

    def _maps(self) -> dict[str, Floorplan]:
        """Return the undamaged maps by their digests."""
        plans, known = {}, self._checksums()
        for row in self._rows("SELECT * FROM floorplan"):
            try:
                if checksum("floorplan", row) in known:
                    plans[row[0]] = floorplan_of(row)
            except UNREADABLE:
                continue
        return plans

    # -- checks ---------------------------------------------------------------------------------------

    def _check(self) -> None:
        """Refuse a file that is damaged as a whole, no store, or one whose experiment is damaged."""
        self._refuse_strange()
        if not self._has("meta") and not self._rows("SELECT 1 FROM sqlite_master"):
            raise InputError(
                f"{self.path} is being made by another process; wait, or fly the same compare command again if none is"
            )
        found = self._rows("SELECT value FROM meta WHERE key = 'format'")
        if found != [(str(FORMAT),)]:
            got = found[0][0] if found else None
            raise InputError(f"{self.path}: expected a store of format {FORMAT}, got {got!r}; use another folder")
        (first, *_), *_ = self._rows("PRAGMA integrity_check(1)")
        if first != "ok":
            raise damaged(self.path, first)
        if not self._has("checksum"):
            raise InputError(
                f"{self.path}: expected a store with checksums, got one from before version 0.2.0; let compare of "
                "version 0.2.0 resume the folder, which adds them, or fly the experiment into another folder"
            )
        known = self._checksums()
        for table in (*SETTINGS, *(["attempt"] if self._has("attempt") else [])):
            for row in self._rows(f"SELECT * FROM {table}"):
                if checksum(table, row) not in known:
                    raise damaged(self.path, f"{table} {row[0]!r}: {NO_CHECKSUM}")

    def _refuse_strange(self) -> None:
        """Refuse a file with triggers, views or tables that are none of a store: they would change what it holds."""
        for kind, name, made in self._rows("SELECT type, name, sql FROM sqlite_master"):
            plain = kind == "table" and str(made).upper().startswith("CREATE TABLE")
            if kind != "index" and not (plain and (name in TABLES or name.startswith("sqlite_"))):
                raise InputError(
                    f"{self.path}: expected a results store, got a database with the {kind} "
                    f"{one_line(repr(name), 80)}; remove that, or use another folder"
                )

    def _checksums(self) -> set[bytes]:
        """Return the checksums of all rows."""
        return {digest for (digest,) in self._rows("SELECT digest FROM checksum")}

    def _has(self, table: str) -> bool:
        return bool(self._rows(f"SELECT 1 FROM sqlite_master WHERE name = '{table}'"))

    def _facts(self, text: str, what: str) -> dict[str, Any]:
        with self._understood(what):
            return dict(json.loads(text))

    def _rows(self, query: str) -> list[Row]:
        with self._readable():
            try:
                return self._db.execute(query).fetchall()
            except sqlite3.OperationalError:  # perhaps a damaged text, which is read here and refused by its checksum
                self._db.text_factory = _decoded
                return self._db.execute(query).fetchall()

    @contextmanager
    def _understood(self, what: str) -> Iterator[None]:
        """Refuse a store in which ``what`` the block reads cannot be understood."""
        try:
            yield
        except UNREADABLE as error:
            raise damaged(self.path, f"{what}: {error}") from error

    @contextmanager
    def _readable(self) -> Iterator[None]:
        """Refuse a file that SQLite cannot read."""
        try:
            yield
        except SQL_ERRORS as error:
            raise InputError(
                f"{self.path}: expected a results store, got: {one_line(str(error))}; {REPLACE}"
            ) from error


def _complaint(row: Row, plans: Mapping[str, Floorplan], known: set[bytes]) -> str:
    """Return the damage of a row of :data:`EPISODES` that shows without unpacking it; empty for none."""
    if checksum("episode", row[1:-2]) not in known:
        return NO_CHECKSUM
    if None in row[-2:]:
        return "its policy or scenario is missing"
    return "" if row[6] in plans else "its map is damaged"


def _episode(row: Row, plans: Mapping[str, Floorplan], known: set[bytes], source: StoredSteps) -> Record | Damage:
    if why := _complaint(row, plans, known):
        return _damage(row, why)
    try:
        return StoredRecord.of_row(row[1:-2], row[0], plans, source)
    except UNREADABLE as error:
        return _damage(row, str(error) or type(error).__name__)


def _damage(row: Row, why: str) -> Damage:
    return Damage(row[0], row[1], Task(*row[2:5]), why)
