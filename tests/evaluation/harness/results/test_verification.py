"""No report is written of a store that another program changed while its episodes were flown, or between two runs."""

import json
import sqlite3
from contextlib import closing
from shutil import copy

import pytest

from indoor_explorers.env.errors import RunError
from indoor_explorers.evaluation.driver import fly_missing
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.harness.results.rows import checksum
from indoor_explorers.learners.dddqn.weights import shipped
from tests.marks import slow

BETTER = "UPDATE episode SET metrics = json_set(metrics, '$.t99', 3) WHERE seed = 1"
#: What a policy may do to the store, and how it is told.
CHANGES = {
    "better": (BETTER, "Wander on thesis-open, map 0, seed 1"),
    "removed": ("DELETE FROM episode WHERE seed = 1", "a row of table episode that is missing"),
    "added": (
        "INSERT INTO episode SELECT policy, scenario, 0, 7, run, floorplan, team, budget, reachable, outcome, reason, "
        "steps, metrics, covered, cells, actions, seconds, sent FROM episode WHERE seed = 2",
        "Wander on thesis-open, map 0, seed 7",
    ),
    "forged": ("UPDATE policy SET facts = json_set(facts, '$.failed_check', '')", "a row of table policy"),
}
AGAIN = "leave out the policies that you do not trust, then the same command flies the episodes again"


def fly(out, watcher=None, policy="tests.evaluation.plugins:Wander", episodes=2):
    request = ComparisonRequest.of(policies=[policy], scenario="thesis-open", episodes=episodes, workers=0)
    fly_missing(plan(request), out, request, watcher=watcher)
    return Results.load(out).records


def edit(out, change):
    """Change a store as a policy could, and sign all that is in it."""
    with closing(sqlite3.connect(out / "results.db")) as db, db:
        db.execute(change)
        for table in ("run", "policy", "floorplan", "episode"):
            for row in db.execute(f"SELECT * FROM {table}").fetchall():
                db.execute("INSERT OR IGNORE INTO checksum VALUES (?)", (checksum(table, row),))


class Edits:
    """A watcher that changes the store after each episode."""

    def __init__(self, out, change):
        self.flown = lambda records, seconds_left: edit(out, change)

    def begin(self, total, missing):
        pass


@pytest.mark.parametrize("name", ["better", *slow(*[*CHANGES][1:])])
def test_what_another_program_changed_during_a_run_is_refused(name, tmp_path):
    change, named = CHANGES[name]
    fly(tmp_path)  # episodes of an earlier run are looked at, too
    with pytest.raises(
        RunError, match=rf"changed it while this command ran: (tests.evaluation.plugins:)?{named}; leave out"
    ) as told:
        fly(tmp_path, Edits(tmp_path, change), episodes=3)
    if " episode " not in change:
        assert str(told.value).endswith("then start again with --fresh")
    else:
        assert str(told.value).endswith(AGAIN)
        assert [record.metrics["t99"] == 3 for record in fly(tmp_path, episodes=3)] == [False] * 3


class Training(Edits):
    """A watcher that replaces weights after each episode, as a training that goes on does."""

    def __init__(self, weights):
        self.flown = lambda records, seconds_left: copy(shipped()["thesis-obstacles"], weights)


def test_weights_that_change_while_they_fly_are_refused(tmp_path):
    weights, out = tmp_path / "weights.safetensors", tmp_path / "out"
    copy(shipped()["thesis-open"], weights)
    fly(out, policy=f"dddqn:{weights}", episodes=1)
    copy(shipped()["thesis-open"], weights)  # the same again, only newer
    with pytest.raises(
        RunError, match=r"got changes while they flew, of 'dddqn:.*': weights: weights.safetensors; these"
    ):
        fly(out, Training(weights), policy=f"dddqn:{weights}", episodes=2)
    assert [record.task.seed for record in Results.load(out).records] == [0]


def test_episodes_of_earlier_runs_of_the_same_software_are_simulated_again(tmp_path):
    fly(tmp_path)
    edit(tmp_path, BETTER)
    with pytest.raises(RunError, match=rf"Wander on thesis-open, map 0, seed 1: t99 3, simulated .*; {AGAIN}"):
        fly(tmp_path)
    assert [record.metrics["t99"] == 3 for record in fly(tmp_path)] == [False, False]
    edit(tmp_path, BETTER)
    with closing(sqlite3.connect(tmp_path / "results.db")) as db:
        ((facts,), *_) = db.execute("SELECT facts FROM run").fetchall()
    edit(tmp_path, f"UPDATE run SET facts = '{json.dumps(json.loads(facts) | {'commit': '0123'}, sort_keys=True)}'")
    assert [record.metrics["t99"] == 3 for record in fly(tmp_path)] == [False, True]


def test_where_no_plug_in_was_flown_nothing_is_simulated_again(tmp_path):
    fly(tmp_path, policy="random")
    edit(tmp_path, BETTER)
    assert [record.metrics["t99"] == 3 for record in fly(tmp_path, policy="random")] == [False, True]


def test_a_store_that_another_program_empties_during_a_run_is_told_as_that(tmp_path):
    with pytest.raises(RunError, match="another program has removed what this run had written"):
        fly(tmp_path, Edits(tmp_path, "DELETE FROM policy"), episodes=40)
