"""The store: one SQLite file per experiment, append-only, one transaction per finished episode.

Episodes are keyed by (policy, scenario, map, seed); finished keys are skipped, so every run is a resume. Only a failed
episode that was flown again is ever replaced. Maps are kept in the store, so that a report needs nothing else.
"""

from __future__ import annotations

import json
import sqlite3
import zlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import InputError
from indoor_explorers.env.errors import RunError
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.evaluation.episodes.record import FlownEpisode, Outcome, Record
from indoor_explorers.evaluation.experiment.experiment import Experiment, Task, merged_experiments
from indoor_explorers.evaluation.results.policy_version import version_difference

FORMAT = 3
#: Differences that a refusal names.
MOST_NAMED = 4

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


def _packed(array: NDArray[Any]) -> bytes:
    return zlib.compress(np.ascontiguousarray(array).tobytes(), 6)


def _unpacked(blob: bytes, kind: type, *shape: int) -> NDArray[Any]:
    return np.frombuffer(zlib.decompress(blob), kind).reshape(shape)


@contextmanager
def _transaction(db: sqlite3.Connection, path: Path) -> Iterator[None]:
    """Write everything in the block or nothing.

    Raises:
        RunError: the disk is full, or the file cannot be written for another reason.

    """
    try:
        with db:
            db.execute("BEGIN IMMEDIATE")
            yield
    except sqlite3.OperationalError as error:
        raise _not_written(path, error) from error


def _not_written(path: Path, error: sqlite3.Error) -> RunError:
    return RunError(
        f"{path} cannot be written: {error}; the finished episodes are kept: make room on the disk, and the same "
        "command goes on from there"
    )


def _some(differences: list[str]) -> str:
    """Return the first of some differences, and how many more there are."""
    more = [f"and {len(differences) - MOST_NAMED} more"] if len(differences) > MOST_NAMED else []
    return "; ".join(differences[:MOST_NAMED] + more)


class Store:
    """The results of one experiment in a file; use as a context manager."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._floorplans: dict[Task, str] = {}
        """The digests of the maps that were added."""
        existed = path.exists()
        try:
            self._db = sqlite3.connect(path, isolation_level=None)
            self._db.execute("PRAGMA journal_mode = WAL")
            self._db.execute("PRAGMA synchronous = NORMAL")
            self._db.execute("PRAGMA foreign_keys = ON")
            if not self._db.execute("SELECT 1 FROM sqlite_master WHERE name = 'meta'").fetchone():
                self._create()
            found = self._db.execute("SELECT value FROM meta WHERE key = 'format'").fetchone()
        except sqlite3.DatabaseError as error:
            if getattr(error, "sqlite_errorcode", 0) & 0xFF in (sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR):
                raise _not_written(path, error) from error
            what = "expected a results store" if existed else "cannot be created"
            raise InputError(
                f"{path}: {what}, got: {error}; choose another folder, or one that can be written"
            ) from error
        if found is None or found[0] != str(FORMAT):
            raise InputError(
                f"{path}: expected a store of format {FORMAT}, got {found and found[0]}; use another folder"
            )

    def _create(self) -> None:
        self._db.executescript(f"BEGIN IMMEDIATE; {SCHEMA} INSERT INTO meta VALUES ('format', '{FORMAT}'); COMMIT;")

    def __enter__(self) -> Store:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._db.close()

    # -- the experiment -------------------------------------------------------------------------------

    def begin_run(
        self,
        experiment: Experiment,
        policies: dict[str, dict[str, Any]],
        facts: dict[str, Any],
        *,
        refly: bool = False,
        fresh: bool = False,
    ) -> int:
        """Store the experiment and a new run of it; return the run's number.

        An experiment may gain policies and episodes. Any other difference from what the store holds is refused, but
        with ``refly`` a policy that is another version of the stored one loses its episodes, and with ``fresh``
        everything that is stored goes.

        Raises:
            InputError: the store holds another experiment; the message names what differs.
            RunError: the disk is full.

        """
        if not fresh:
            self._refuse_another(experiment, policies, refly=refly)
        with _transaction(self._db, self.path):
            if fresh:
                self._db.execute("DELETE FROM meta WHERE key = 'seed'")
                for table in ("episode", "floorplan", "scenario", "policy", "run"):
                    self._db.execute(f"DELETE FROM {table}")
            for name in self._other_versions(policies):
                self._db.execute("DELETE FROM episode WHERE policy = ?", (name,))
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
        assert run is not None
        return run

    def _other_versions(self, policies: dict[str, dict[str, Any]]) -> dict[str, str]:
        """Return how policies differ from those of the same name that the store has episodes of, by name."""
        rows = self._db.execute("SELECT name, facts FROM policy WHERE name IN (SELECT policy FROM episode)")
        known = {name: json.loads(facts) for name, facts in rows}
        found = {name: version_difference(known[name], policies[name]) for name in policies if name in known}
        return {name: difference for name, difference in found.items() if difference}

    def _refuse_another(
        self, experiment: Experiment, policies: dict[str, dict[str, Any]], *, refly: bool = False
    ) -> None:
        way_out = "choose another --out, or start this one again with --fresh"
        seed = self._db.execute("SELECT value FROM meta WHERE key = 'seed'").fetchone()
        if seed is None:
            return
        differing = []
        if seed[0] != str(experiment.seed):
            differing.append(f"seed ({seed[0]} there, {experiment.seed} here)")
        held = dict(self._db.execute("SELECT name, fingerprint FROM scenario"))
        asked = {scenario.name: scenario.fingerprint for scenario in experiment.scenarios}
        if set(held) != set(asked):
            differing.append(f"scenarios ({', '.join(held)} there, {', '.join(asked)} here)")
        differing += [
            f"the settings of scenario {name!r}" for name in asked if name in held and held[name] != asked[name]
        ]
        if differing:
            named = _some(differing)
            raise InputError(f"{self.path} holds another experiment; what differs: {named}; {way_out}")
        others = [f"policy {name!r}: {difference}" for name, difference in self._other_versions(policies).items()]
        if others and not refly:
            raise InputError(
                f"{self.path} holds episodes flown by another version of a policy; what differs: {_some(others)}; "
                "fly them again with --refly, or choose another --out"
            )

    # -- episodes -------------------------------------------------------------------------------------

    def finished(self, *, failed: bool = True) -> set[tuple[str, Task]]:
        """Return the keys of all stored episodes, with or without the ``failed`` ones."""
        which = "" if failed else f"WHERE outcome <> '{Outcome.FAILED}'"
        rows = self._db.execute(f"SELECT policy, scenario, map_index, seed FROM episode {which}")
        return {(policy, Task(scenario, index, seed)) for policy, scenario, index, seed in rows}

    def add(self, record: FlownEpisode, run: int, *, replace_failed: bool = False) -> None:
        """Add one episode in a transaction of its own; an episode that is already stored is left as it is.

        The first episode of a task must be a :class:`Record`, which has the map. With ``replace_failed`` it replaces
        a failed one.

        Raises:
            RunError: the disk is full; episodes added before are kept.

        """
        with _transaction(self._db, self.path):
            if isinstance(record, Record):
                row = _floorplan_row(record.floorplan)
                self._db.execute(f"INSERT OR IGNORE INTO floorplan VALUES ({_marks(9)})", row)
                self._floorplans[record.task] = record.floorplan.digest
            if replace_failed:
                key = "policy = ? AND scenario = ? AND map_index = ? AND seed = ?"
                gone = (record.policy, *record.task, Outcome.FAILED)
                self._db.execute(f"DELETE FROM episode WHERE {key} AND outcome = ?", gone)
            row = _episode_row(record, run, self._floorplans[record.task])
            self._db.execute(f"INSERT OR IGNORE INTO episode VALUES ({_marks(18)})", row)

    def policies(self) -> dict[str, dict[str, Any]]:
        """Return the facts of each policy by name, in the order of the experiment."""
        rows = self._db.execute("SELECT name, facts FROM policy ORDER BY position")
        return {name: json.loads(facts) for name, facts in rows}

    def scenarios(self) -> dict[str, dict[str, Any]]:
        """Return the settings of each scenario by name, ``fingerprint`` included, in order."""
        rows = self._db.execute("SELECT name, fingerprint, facts FROM scenario ORDER BY position")
        return {name: {"fingerprint": fingerprint, **json.loads(facts)} for name, fingerprint, facts in rows}

    def runs(self) -> list[dict[str, Any]]:
        """Return the facts of each run that an episode is from, oldest first."""
        flown = "SELECT facts FROM run WHERE id IN (SELECT run FROM episode) ORDER BY id"
        return [json.loads(facts) for (facts,) in self._db.execute(flown)]

    def experiment(self) -> str:
        """Return one experiment in TOML for all runs, empty without a run."""
        return merged_experiments([text for (text,) in self._db.execute("SELECT experiment FROM run ORDER BY id")])

    def records(self) -> Iterable[Record]:
        """Yield all episodes, ordered by policy, scenario, map and seed."""
        plans = {row[0]: _floorplan(row) for row in self._db.execute("SELECT * FROM floorplan")}
        rows = self._db.execute(
            "SELECT episode.* FROM episode JOIN policy ON policy.name = policy"
            " JOIN scenario ON scenario.name = scenario"
            " ORDER BY scenario.position, policy.position, map_index, seed"
        )
        for policy, scenario, index, seed, _, plan, team, budget, reachable, outcome, reason, steps, *blobs in rows:
            metrics, covered, cells, actions, seconds, sent = blobs
            yield Record(
                policy=policy,
                task=Task(scenario, index, seed),
                floorplan=plans[plan],
                team=team,
                budget=budget,
                reachable=reachable,
                outcome=Outcome(outcome),
                reason=reason,
                metrics=json.loads(metrics),
                covered=_unpacked(covered, np.int32, steps + 1, 1 + team),
                cells=_unpacked(cells, np.int16, steps + 1, team, 2),
                actions=_unpacked(actions, np.uint8, steps, team),
                seconds=_unpacked(seconds, np.float32, steps + 1),
                sent=_unpacked(sent, np.int64, steps + 1),
            )


def _marks(count: int) -> str:
    return ", ".join("?" * count)


def _floorplan_row(plan: Floorplan) -> tuple[Any, ...]:
    start = plan.start or (None, None)
    return (plan.digest, plan.name, *plan.shape, plan.resolution, plan.kept, _packed(plan.truth), *start)


def _episode_row(record: FlownEpisode, run: int, floorplan: str) -> tuple[Any, ...]:
    return (
        *(record.policy, *record.task, run, floorplan, record.team, record.budget, record.reachable),
        *(str(record.outcome), record.reason, record.steps, json.dumps(record.metrics)),
        _packed(record.covered.astype(np.int32)),
        _packed(record.cells.astype(np.int16)),
        _packed(record.actions.astype(np.uint8)),
        _packed(record.seconds.astype(np.float32)),
        _packed(record.sent.astype(np.int64)),
    )


def _floorplan(facts: tuple[Any, ...]) -> Floorplan:
    _, name, height, width, resolution, kept, cells, row, column = facts
    start = None if row is None else (row, column)
    return Floorplan(_unpacked(cells, np.uint8, height, width), name, resolution, kept, start)
