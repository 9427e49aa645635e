"""No report is written of a store that another program changed while its episodes were flown, or between two runs."""

import json
import sqlite3
from contextlib import closing

import pytest

from indoor_explorers.env.errors import RunError
from indoor_explorers.evaluation.driver import fly_missing
from indoor_explorers.evaluation.experiment.planning import plan
from indoor_explorers.evaluation.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.results.results import Results
from indoor_explorers.evaluation.results.rows import checksum


def fly(out, watcher=None, policy="tests.evaluation.plugins:Wander"):
    request = ComparisonRequest.of(policies=[policy], scenario="thesis-open", episodes=2, workers=0)
    fly_missing(plan(request), out, request, watcher=watcher)


def edit(out, table, change):
    """Change a table as a policy could, and sign every row of it."""
    with closing(sqlite3.connect(out / "results.db")) as db, db:
        db.execute(change)
        for row in db.execute(f"SELECT * FROM {table}").fetchall():
            db.execute("INSERT OR IGNORE INTO checksum VALUES (?)", (checksum(table, row),))


BETTER = "UPDATE episode SET metrics = json_set(metrics, '$.t99', 3)"
COLUMNS = (
    "run, floorplan, team, budget, reachable, outcome, reason, steps, metrics, covered, cells, actions, seconds, sent"
)
CHANGES = {
    "better": ("episode", BETTER, "Wander on thesis-open, map 0, seed 1"),
    "removed": ("episode", "DELETE FROM episode WHERE seed = 1", "a row of table episode that is missing"),
    "added": (
        "episode",
        f"INSERT INTO episode SELECT policy, scenario, 0, 7, {COLUMNS} FROM episode WHERE seed = 1",
        "seed 7; leave out",
    ),
}


class Edits:
    """A watcher that changes the store after the last episode."""

    def __init__(self, *change):
        self.change, self.left = change, 0

    def begin(self, total, missing):
        self.left = missing

    def flown(self, records, seconds_left):
        self.left -= len(records)
        if not self.left:
            edit(*self.change)


@pytest.mark.parametrize("change", CHANGES)
def test_episodes_changed_while_others_flew_are_refused_and_flown_again(change, tmp_path):
    table, sql, named = CHANGES[change]
    with pytest.raises(
        RunError, match="another program, perhaps a policy, changed what this command had written"
    ) as told:
        fly(tmp_path, Edits(tmp_path, table, sql))
    assert named in str(told.value)
    assert str(told.value).endswith("then the same command flies the episodes again")
    fly(tmp_path)
    results = Results.load(tmp_path)
    assert {record.task.seed for record in results.records} == {0, 1}
    assert all(record.metrics["t99"] != 3 for record in results.records)


@pytest.mark.parametrize(
    ("table", "sql"),
    [
        ("policy", "UPDATE policy SET facts = json_set(facts, '$.failed_check', '')"),
        ("floorplan", "UPDATE floorplan SET name = 'another'"),
    ],
)
def test_changed_facts_and_maps_are_refused(table, sql, tmp_path):
    with pytest.raises(RunError, match=rf"had written: a row of table {table}.*; .*, then start again with --fresh"):
        fly(tmp_path, Edits(tmp_path, table, sql))


def test_episodes_of_an_earlier_run_are_simulated_again(tmp_path):
    fly(tmp_path)
    edit(tmp_path, "episode", f"{BETTER} WHERE seed = 1")
    with pytest.raises(RunError, match=r"Wander on thesis-open, map 0, seed 1: t99 3, simulated .*; leave out"):
        fly(tmp_path)
    fly(tmp_path)
    assert all(record.metrics["t99"] != 3 for record in Results.load(tmp_path).records)


def test_earlier_runs_of_other_software_or_without_plug_ins_are_not_simulated(tmp_path):
    fly(tmp_path / "other")
    edit(tmp_path / "other", "episode", f"{BETTER} WHERE seed = 1")
    with closing(sqlite3.connect(tmp_path / "other" / "results.db")) as db:
        (facts,) = db.execute("SELECT facts FROM run").fetchone()
    older = json.dumps(json.loads(facts) | {"commit": "0123"}, sort_keys=True)
    edit(tmp_path / "other", "run", f"UPDATE run SET facts = '{older}'")
    fly(tmp_path / "other")
    fly(tmp_path / "own", policy="random")
    edit(tmp_path / "own", "episode", BETTER)
    fly(tmp_path / "own", policy="random")
