"""The store: one SQLite file per experiment, append-only, one transaction per finished episode.

Episodes are keyed by (policy, scenario, map, seed); finished keys are skipped, so every run is a resume. Only a failed
episode that was flown again is ever replaced. Maps are kept in the store, so that a report needs nothing else. Every
row has a checksum; damaged episodes are set aside when a run begins, and flown again.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.errors import one_line
from indoor_explorers.evaluation.harness.episodes.record import FlownEpisode, Outcome, Record, is_of_machine
from indoor_explorers.evaluation.harness.experiment.experiment import Experiment, Task
from indoor_explorers.evaluation.harness.results.database import (
    SQL_ERRORS,
    connect,
    is_corrupt,
    not_written,
    remove,
    transaction,
    write_ahead,
)
from indoor_explorers.evaluation.harness.results.fingerprints import task_difference
from indoor_explorers.evaluation.harness.results.origins import Origin
from indoor_explorers.evaluation.harness.results.policy_version import version_difference
from indoor_explorers.evaluation.harness.results.reading import FORMAT, SETTINGS
from indoor_explorers.evaluation.harness.results.rows import (
    ATTEMPTS,
    CHECKSUMS,
    ORIGINS,
    SCHEMA,
    TABLES,
    Row,
    episode_row,
    floorplan_row,
)
from indoor_explorers.evaluation.harness.results.written_rows import WrittenRows

#: Differences that a refusal names.
MOST_NAMED = 4


def some_of(differences: list[str]) -> str:
    """Return the first of some differences, and how many more there are."""
    more = [f"and {len(differences) - MOST_NAMED} more"] if len(differences) > MOST_NAMED else []
    return "; ".join(differences[:MOST_NAMED] + more)


class Store(WrittenRows):
    """The results of one experiment in a file, opened for writing, and made if it is not there.

    With ``fresh``, what the file holds counts for nothing, damaged or not: the first run deletes it. A file that SQLite
    cannot read is deleted at once.
    """

    def __init__(self, path: Path, *, fresh: bool = False) -> None:
        super().__init__(path)
        self._fresh = fresh
        self._digests: dict[Task, str] = {}
        """The digests of the maps that were added."""
        self._scenarios: dict[str, Scenario] = {}
        """The scenarios of the run by name."""
        self._known: set[str] = set()
        """The digests of the maps whose origins are stored."""
        existed = path.exists()
        if existed and not path.is_file():
            raise InputError(f"{path}: expected a results store, got no regular file; choose another folder")
        try:
            if fresh and existed and is_corrupt(path):
                remove(path.resolve())
            self._db = connect(path.resolve().as_uri())
            write_ahead(self._db)
            self._db.execute("PRAGMA synchronous = NORMAL")
            self._db.execute("PRAGMA foreign_keys = ON")
            with self._db:
                self._db.execute("BEGIN IMMEDIATE")  # another process may be opening it too
                self._refuse_strange()
                self._create()
                if not fresh:
                    self._check()
                    self._db.execute(ATTEMPTS)
                    self._db.execute(ORIGINS)
        except SQL_ERRORS as error:
            if getattr(error, "sqlite_errorcode", 0) & 0xFF in (sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR):
                raise not_written(path, error) from error
            what = "expected a results store" if existed else "cannot be created"
            raise InputError(
                f"{path}: {what}, got: {one_line(str(error))}; choose another folder, or one that can be written"
            ) from error

    def _create(self) -> None:
        """Make the tables of an empty file."""
        if not self._db.execute("SELECT 1 FROM sqlite_master WHERE name = 'meta'").fetchone():
            for statement in (
                *SCHEMA.split(";"),
                CHECKSUMS,
                ATTEMPTS,
                ORIGINS,
                f"INSERT INTO meta VALUES ('format', '{FORMAT}')",
            ):
                self._db.execute(statement)
            self._sign("meta")

    def _sign(self, table: str, which: str = "true", *values: Any) -> None:
        """Store the checksums of some rows of a table, of all by default."""
        digests = [(digest,) for digest in self._note(table, which, *values)]
        self._db.executemany("INSERT OR IGNORE INTO checksum VALUES (?)", digests)

    def _set_aside_damaged(self) -> None:
        """Move damaged episodes to a table of their own; drop damaged maps and origins, which are made again."""
        with transaction(self._db, self.path):
            rowids, sound = [each.rowid for each in self._damages()], self._maps()
            plans = [row for row in self._rows("SELECT digest FROM floorplan") if row[0] not in sound]
            self._move_aside(rowids)
            self._db.executemany("DELETE FROM floorplan WHERE digest = ?", plans)
            known = self.origins()
            lost = [row for row in self._rows("SELECT floorplan FROM origin") if row[0] not in known]
            self._db.executemany("DELETE FROM origin WHERE floorplan = ?", lost)

    # -- the experiment -------------------------------------------------------------------------------

    def policies(self) -> dict[str, dict[str, Any]]:
        """Return the facts of each policy by name, in the order of the experiment; none in a fresh store."""
        return {} if self._fresh else super().policies()

    def begin_run(
        self,
        experiment: Experiment,
        policies: dict[str, dict[str, Any]],
        facts: dict[str, Any],
        *,
        refly: bool = False,
    ) -> int:
        """Store the experiment and a new run of it; return the run's number.

        An experiment may gain policies and episodes. Any other difference from what the store holds is refused, but
        with ``refly`` a policy that is another version of the stored one loses its episodes, and in a fresh store
        everything that the file holds goes.

        Raises:
            InputError: the store holds another experiment; the message names what differs.
            RunError: the disk is full.

        """
        others: dict[str, str] = {}
        if not self._fresh:
            self._refuse_another(experiment)
            others = self._other_versions(policies)
            self._refuse_versions({} if refly else others)
        self._noted.clear()
        with transaction(self._db, self.path):
            if self._fresh:
                for table in TABLES:
                    self._db.execute(f"DROP TABLE IF EXISTS {table}")
                self._create()
                self._fresh = False
            for name in others:
                self._db.execute("DELETE FROM episode WHERE policy = ?", (name,))
                self._db.execute("DELETE FROM attempt WHERE policy = ?", (name,))
            for name, about in policies.items():
                self._db.execute(
                    "INSERT INTO policy VALUES (?, (SELECT count(*) FROM policy), ?)"
                    " ON CONFLICT (name) DO UPDATE SET facts = excluded.facts",
                    (name, json.dumps(about, sort_keys=True)),
                )
            for scenario in experiment.scenarios:
                self._db.execute(
                    "INSERT OR IGNORE INTO scenario VALUES (?, (SELECT count(*) FROM scenario), ?, ?)",
                    (scenario.name, scenario.fingerprint, scenario.model_dump_json()),
                )
            self._db.execute("INSERT OR IGNORE INTO meta VALUES ('seed', ?)", (str(experiment.seed),))
            entry = (json.dumps(facts, sort_keys=True), experiment.to_toml())
            run = self._db.execute("INSERT INTO run (facts, experiment) VALUES (?, ?)", entry).lastrowid
            for table in SETTINGS:
                self._sign(table)
        self._set_aside_damaged()
        for table in ("floorplan", "origin", "episode"):
            self._note(table)
        self._scenarios = {scenario.name: scenario for scenario in experiment.scenarios}
        self._known = set(self.origins())
        assert run is not None
        return run

    def add_facts(self, more: Mapping[str, Mapping[str, Any]]) -> None:
        """Add facts to those of policies by name.

        Raises:
            RunError: the disk is full.

        """
        about = self.policies()
        with transaction(self._db, self.path):
            for name, facts in more.items():
                text = json.dumps(about[name] | dict(facts), sort_keys=True)
                self._db.execute("UPDATE policy SET facts = ? WHERE name = ?", (text, name))
                self._sign("policy", "name = ?", name)

    def _other_versions(self, policies: dict[str, dict[str, Any]]) -> dict[str, str]:
        """Return how policies differ from those of the same name that the store has episodes of, by name."""
        rows = self._db.execute("SELECT name, facts FROM policy WHERE name IN (SELECT policy FROM episode)")
        known = {name: json.loads(facts) for name, facts in rows}
        found = {name: version_difference(known[name], policies[name]) for name in policies if name in known}
        return {name: difference for name, difference in found.items() if difference}

    def _refuse_another(self, experiment: Experiment) -> None:
        way_out = "choose another --out, or start this one again with --fresh"
        seed = self._db.execute("SELECT value FROM meta WHERE key = 'seed'").fetchone()
        if seed is None:
            return
        differing = []
        if seed[0] != str(experiment.seed):
            differing.append(f"seed ({seed[0]} there, {experiment.seed} here)")
        rows = self._db.execute("SELECT name, fingerprint, facts FROM scenario")
        held = {name: (fingerprint, json.loads(facts)) for name, fingerprint, facts in rows}
        asked = {scenario.name: scenario for scenario in experiment.scenarios}
        if set(held) != set(asked):
            differing.append(f"scenarios ({', '.join(held)} there, {', '.join(asked)} here)")
        differing += filter(None, (task_difference(*held[name], asked[name]) for name in asked if name in held))
        if differing:
            named = some_of(differing)
            raise InputError(f"{self.path} holds another experiment; what differs: {named}; {way_out}")

    def _refuse_versions(self, others: dict[str, str]) -> None:
        """Refuse policies that are other versions of the stored ones, given how each differs."""
        if others:
            differing = some_of([f"policy {name!r}: {difference}" for name, difference in others.items()])
            raise InputError(
                f"{self.path} holds episodes flown by another version of a policy; what differs: {differing}; "
                "fly them again with --refly, or choose another --out"
            )

    # -- episodes -------------------------------------------------------------------------------------

    def finished(self, *, failed: bool = True) -> set[tuple[str, Task]]:
        """Return the keys of all stored episodes, with or without the ``failed`` ones."""
        which = "" if failed else f"WHERE outcome <> '{Outcome.FAILED}'"
        rows = self._rows(f"SELECT policy, scenario, map_index, seed FROM episode {which}")
        return {(policy, Task(scenario, index, seed)) for policy, scenario, index, seed in rows}

    def add(self, record: FlownEpisode, run: int, *, replace_failed: bool = False) -> None:
        """Add one episode in a transaction of its own; an episode that is already stored is left as it is.

        The first episode of a task must be a :class:`Record`, which has the map. With ``replace_failed`` it is
        another attempt at a failed one, and replaces it if the machine failed; the policy's own failure stays.

        Raises:
            RunError: the disk is full; episodes added before are kept.

        """
        origin = self._new_origin(record) if isinstance(record, Record) else None
        with transaction(self._db, self.path):
            if origin is not None:
                self._insert("origin", origin)
            if isinstance(record, Record):
                self._insert("floorplan", floorplan_row(record.floorplan))
                self._digests[record.task] = record.floorplan.digest
            if replace_failed:
                self._add_attempt(record)
            self._insert("episode", episode_row(record, run, self._digests[record.task]))

    def _new_origin(self, record: Record) -> Row | None:
        """Return the row of the origin of an episode's map; None where it is stored."""
        digest, task = record.floorplan.digest, record.task
        if digest in self._known or task.scenario not in self._scenarios:
            return None
        self._known.add(digest)
        return (digest, *Origin.of(self._scenarios[task.scenario], task.map_index, record.floorplan))

    def _add_attempt(self, record: FlownEpisode) -> None:
        """Add another attempt at a failed episode: the first one counts unless the machine failed."""
        which = "FROM episode WHERE policy = ? AND scenario = ? AND map_index = ? AND seed = ? AND outcome = ?"
        key = (record.policy, *record.task)
        found = self._db.execute(f"SELECT rowid, outcome, reason, steps {which}", (*key, Outcome.FAILED)).fetchone()
        if found is None:
            return
        rowid, *first = found
        if is_of_machine(first[1]):
            self._db.execute(f"DELETE {which}", (*key, Outcome.FAILED))
            self._noted.pop(("episode", rowid), None)
            self._insert("attempt", (*key, *first))
        else:
            self._insert("attempt", (*key, str(record.outcome), record.reason, record.steps))

    def _insert(self, table: str, row: Row) -> None:
        """Insert a row with its checksum; a row of the same key is left as it is."""
        marks = ", ".join("?" * len(row))
        added = self._db.execute(f"INSERT OR IGNORE INTO {table} VALUES ({marks})", row)
        if added.rowcount:
            self._sign(table, "rowid = ?", added.lastrowid)
