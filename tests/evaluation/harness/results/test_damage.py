"""Damaged stores: a refusal in one line or the same results, never others; what is damaged is flown again."""

import multiprocessing
import os
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing

import numpy as np
import pytest

from indoor_explorers.env import InputError
from indoor_explorers.env.errors import RunError
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.results.reading import StoreReader
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.harness.results.store import Store
from tests.evaluation.harness.results.test_store import about, experiment, filled
from tests.evaluation.plugins import Wander

FLIPS = 60


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    """Return a folder with a store that must not be changed."""
    folder = tmp_path_factory.mktemp("sound")
    filled(folder / "results.db")
    return folder


@pytest.fixture
def folder(sound, tmp_path):
    shutil.copytree(sound, tmp_path, dirs_exist_ok=True)
    return tmp_path


def change(folder, statement, *values):
    with closing(sqlite3.connect(folder / "results.db")) as db, db:
        db.execute(statement, values)


def one_line(error):
    assert "\n" not in str(error)
    return str(error)


def told(folder):
    """Return all that results tell, or the refusal."""
    try:
        results = Results.load(folder)
    except InputError as error:
        return one_line(error)
    flown = [(r.policy, r.task, r.outcome, r.reason, r.metrics, r.actions.tobytes()) for r in results.records]
    return results.summary().to_csv(), results.policies, results.scenarios, results.runs, flown


def flip(file, rng):
    content = bytearray(file.read_bytes())
    content[rng.integers(len(content))] ^= 1 << rng.integers(8)
    file.write_bytes(content)


def test_a_flipped_bit_changes_nothing_or_is_refused(sound, tmp_path):
    rng, whole, refused = np.random.default_rng(1), told(sound), []
    for _ in range(FLIPS):
        shutil.copytree(sound, tmp_path, dirs_exist_ok=True)
        flip(tmp_path / "results.db", rng)
        got = told(tmp_path)
        refused += [got] if isinstance(got, str) else []
        assert isinstance(got, str) or got == whole
    assert refused


def test_a_store_with_a_flipped_bit_is_resumed_or_refused(sound, tmp_path):
    rng, whole, planned = np.random.default_rng(2), told(sound), experiment()
    for _ in range(FLIPS // 2):
        shutil.copytree(sound, tmp_path, dirs_exist_ok=True)
        flip(tmp_path / "results.db", rng)
        try:
            with Store(tmp_path / "results.db") as store:
                run = store.begin_run(planned, about(planned), {"command": "x"})
                done = store.finished()
                missing = [task for task in planned.tasks() if ("w", task) not in done]
                for record in fly(Wander(), "w", planned.scenarios[0], missing):
                    store.add(record, run)
        except (InputError, RunError) as error:
            one_line(error)
        else:
            flown = [entry[:4] + entry[5:] for entry in told(tmp_path)[4]]
            assert flown == [entry[:4] + entry[5:] for entry in whole[4]]
        for file in tmp_path.iterdir():
            file.unlink()


@pytest.mark.parametrize(
    ("statement", "values", "message"),
    [
        (
            "UPDATE episode SET steps = 999999 WHERE seed = 6",
            (),
            "policy 'w', scenario 'thesis-team-2', map 0, seed 6",
        ),
        ("UPDATE episode SET team = -1 WHERE seed = 6", (), "seed 6"),
        ("UPDATE episode SET reachable = 0 WHERE seed = 6", (), "seed 6"),
        ("UPDATE episode SET outcome = 'splendid' WHERE seed = 6", (), "seed 6"),
        ("UPDATE episode SET cells = ? WHERE seed = 6", (b"cells",), "seed 6"),
        ("UPDATE episode SET metrics = '[' WHERE seed = 6", (), "seed 6"),
        ("UPDATE episode SET metrics = json_set(metrics, '$.t90', 3) WHERE seed = 6", (), "seed 6"),
        ("UPDATE episode SET metrics = json_set(metrics, '$.auc', 0.99) WHERE seed = 6", (), "seed 6"),
        ("UPDATE episode SET metrics = json_set(metrics, '$.path_length', 1) WHERE seed = 6", (), "seed 6"),
        ("UPDATE floorplan SET height = 7", (), "damaged: "),
        ("UPDATE floorplan SET cells = ?", (b"cells",), "its map is damaged"),
        ("UPDATE scenario SET facts = json_set(facts, '$.team', -4)", (), "thesis-team-2"),
        ("UPDATE scenario SET facts = '{'", (), "thesis-team-2"),
        ("UPDATE policy SET facts = '7'", (), "'w'"),
        ("UPDATE run SET experiment = 'x'", (), "run"),
    ],
)
def test_values_that_cannot_be_are_one_line(statement, values, message, folder):
    change(folder, statement, *values)
    got = told(folder)
    assert isinstance(got, str)
    assert "results.db is damaged" in got
    assert message in got


def test_a_store_from_before_the_checksums_is_refused_and_left_as_it_is(folder):
    change(folder, "DROP TABLE checksum")
    before = (folder / "results.db").read_bytes()
    assert "got one from before version 0.2.0; let compare of version 0.2.0 resume the folder" in told(folder)
    with pytest.raises(InputError, match="expected a store with checksums"):
        Store(folder / "results.db")
    assert (folder / "results.db").read_bytes() == before


def test_damaged_episodes_are_flown_again_and_kept_aside(folder):
    whole, planned = told(folder), experiment()
    change(folder, "UPDATE episode SET seed = 99 WHERE seed = 6")
    with Store(folder / "results.db") as store:
        run = store.begin_run(planned, about(planned), {"command": "x"})
        missing = [task for task in planned.tasks() if ("w", task) not in store.finished()]
        assert [task.seed for task in missing] == [6]
        for record in fly(Wander(), "w", planned.scenarios[0], missing):
            store.add(record, run)
    assert [entry[1:4] for entry in told(folder)[4]] == [entry[1:4] for entry in whole[4]]
    with closing(sqlite3.connect(folder / "results.db")) as db:
        assert db.execute("SELECT seed FROM damaged").fetchall() == [(99,)]
    assert Results.load(folder).warnings[0].startswith("1 damaged episode was set aside")


READ = """
import os, sys
from pathlib import Path
from indoor_explorers.evaluation.harness.results.results import Results
os.setuid(int(sys.argv[2]))
print(len(Results.load(Path(sys.argv[1])).records))
"""


def read_as(user, folder):
    """Read a store in a process of another user; returns what it printed, or its last line of errors."""
    words = [sys.executable, "-P", "-c", READ, str(folder), str(user)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60, check=False)
    return done.stdout.strip() or done.stderr.strip().splitlines()[-1]


@pytest.fixture
def shared_folder(sound, tmp_path):
    """Return a copy of the store in a folder that other users can read."""
    folder = tmp_path / "shared"
    shutil.copytree(sound, folder)
    for part in (folder, *folder.parents):
        if part.is_relative_to(tmp_path.parents[2]) and part.stat().st_uid == os.getuid():
            part.chmod(0o755)
    return folder


@pytest.mark.skipif(os.getuid() != 0, reason="only root may become another user")
def test_a_store_of_another_user_is_read(shared_folder):
    assert read_as(65534, shared_folder) == "3"
    assert [file.name for file in shared_folder.iterdir()] == ["results.db"]


@pytest.mark.skipif(os.getuid() != 0, reason="only root may become another user")
def test_a_store_of_another_user_is_read_while_that_one_writes(shared_folder):
    with Store(shared_folder / "results.db") as store:
        store.begin_run(experiment(episodes=4), about(experiment()), {})
        assert (shared_folder / "results.db-wal").stat().st_size
        assert read_as(65534, shared_folder) == "3"


def test_reading_leaves_no_file_behind_and_changes_nothing(folder):
    before = (folder / "results.db").read_bytes()
    folder.chmod(0o555)
    told(folder)
    folder.chmod(0o755)
    assert [file.name for file in folder.iterdir()] == ["results.db"]
    assert (folder / "results.db").read_bytes() == before


def test_changes_not_yet_in_the_file_are_read(folder):
    with Store(folder / "results.db") as store:
        (record,) = fly(Wander(), "w", experiment().scenarios[0], experiment(episodes=4).tasks()[3:])
        store.add(record, 1)
        with StoreReader(folder / "results.db") as reader:
            assert len(list(reader.records())) == 4


def make_store(path, barrier, found):
    barrier.wait()
    with Store(path) as store:
        found.put(len(store.finished()))


def test_a_store_is_made_by_several_processes_at_once(tmp_path):
    context, processes = multiprocessing.get_context("fork"), 6
    for attempt in range(4):
        barrier, found = context.Barrier(processes), context.SimpleQueue()
        arguments = (tmp_path / f"{attempt}.db", barrier, found)
        running = [context.Process(target=make_store, args=arguments) for _ in range(processes)]
        for process in running:
            process.start()
        for process in running:
            process.join()
        assert [process.exitcode for process in running] == [0] * processes
        assert [found.get() for _ in running] == [0] * processes


WAYS_TO_DAMAGE = {
    "a policy's facts": "UPDATE policy SET facts = '{'",
    "a scenario's": "UPDATE scenario SET facts = '[]'",
    "a run's experiment": "UPDATE run SET experiment = 'what'",
    "the format": "UPDATE meta SET value = '99'",
    "a table": "ALTER TABLE episode DROP COLUMN sent",
    "no checksums": "DROP TABLE checksum",
}


@pytest.mark.parametrize("way", WAYS_TO_DAMAGE)
def test_a_damaged_store_is_started_afresh_where_that_is_asked_for(folder, way):
    change(folder, WAYS_TO_DAMAGE[way])
    with pytest.raises(InputError):
        Results.load(folder)
    with Store(folder / "results.db", fresh=True) as store:
        assert store.policies() == {}
        run = store.begin_run(experiment(episodes=1), about(experiment()), {})
        assert store.finished() == set()
        assert list(store.policies()) == ["w"]
        assert run == 1
    assert Results.load(folder).records == []


def test_a_fresh_store_that_no_run_begins_keeps_what_it_holds(folder):
    before = told(folder)
    with Store(folder / "results.db", fresh=True):
        pass
    assert told(folder) == before


def test_a_store_that_sqlite_cannot_read_is_started_afresh(folder):
    path = folder / "results.db"
    data = bytearray(path.read_bytes())
    data[100:108] = b"\xff" * 8  # the header of the first page, behind that of the file
    path.write_bytes(data)
    with pytest.raises(InputError, match="malformed"):
        Store(path)
    with Store(path, fresh=True) as store:
        store.begin_run(experiment(), about(experiment()), {})
    assert Results.load(folder).records == []


def test_a_file_of_another_kind_is_never_deleted(tmp_path):
    (tmp_path / "results.db").write_text("my notes\n" * 200)
    with pytest.raises(InputError, match="file is not a database"):
        Store(tmp_path / "results.db", fresh=True)
    assert (tmp_path / "results.db").read_text().startswith("my notes")


@pytest.mark.parametrize(
    ("statement", "what"),
    [
        ("CREATE TRIGGER t AFTER INSERT ON episode BEGIN DELETE FROM episode; END", "trigger 't'"),
        ('CREATE VIEW "a\nb" AS SELECT * FROM episode', "view 'a\\nb'"),
        ("CREATE VIRTUAL TABLE attempt USING fts5(policy)", "table 'attempt'"),
    ],
)
def test_triggers_views_and_virtual_tables_are_refused(statement, what, folder):
    change(folder, "DROP TABLE attempt")
    change(folder, statement)
    for opened in (StoreReader, Store):
        with pytest.raises(InputError) as caught, opened(folder / "results.db"):
            pass
        assert f"got a database with the {what}; remove that" in one_line(caught.value)


def test_a_store_that_is_being_made_is_not_called_damaged(tmp_path):
    (tmp_path / "results.db").touch()
    with pytest.raises(InputError, match="is being made by another process; wait"):
        Results.load(tmp_path)


def test_what_is_no_regular_file_is_refused(tmp_path):
    os.mkfifo(tmp_path / "results.db")
    with pytest.raises(InputError, match="got no regular file"):
        Store(tmp_path / "results.db", fresh=True)
    assert (tmp_path / "results.db").is_fifo()
