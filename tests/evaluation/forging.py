"""Stores that somebody changed and signed again, and modules that tell when they are imported."""

import json
import sqlite3
import sys
from pathlib import Path

from indoor_explorers.evaluation.harness.results.rows import checksum

#: What the module of a stranger holds: a lidar that is the exact one, and policies.
MODULE = """
from pathlib import Path
from indoor_explorers.env import UNKNOWN
from indoor_explorers.env.sensing.lidar import scan
from indoor_explorers.planners.random_walk import RandomWalk as Walk
Path(__file__).with_name("IMPORTED").touch()
def exact(truth, cell, lidar_range):
    return scan(truth, cell, lidar_range) != UNKNOWN
"""


def stranger(folder: Path, monkeypatch) -> Path:
    """Put the module ``stranger`` where it can be imported; returns the file that is there once it was."""
    (folder / "stranger.py").write_text(MODULE)
    monkeypatch.syspath_prepend(str(folder))
    monkeypatch.delitem(sys.modules, "stranger", raising=False)
    return folder / "IMPORTED"


def forge(folder: Path, table: str, column: str, change, where: str = "true") -> None:
    """Change a column of a table of a store, which holds JSON if it holds facts, and sign its rows."""
    with sqlite3.connect(folder / "results.db") as db:
        for rowid, value in db.execute(f"SELECT rowid, {column} FROM {table} WHERE {where}").fetchall():
            new = json.dumps(change(json.loads(value))) if column == "facts" else change(value)
            db.execute(f"UPDATE {table} SET {column} = ? WHERE rowid = ?", (new, rowid))
        rows = [(checksum(table, row),) for row in db.execute(f"SELECT * FROM {table}")]
        db.executemany("INSERT OR IGNORE INTO checksum VALUES (?)", rows)
    db.close()


def with_setting(place: str, value):
    """Return a change of stored settings."""
    *parents, leaf = place.split(".")

    def change(settings):
        table = settings
        for parent in parents:
            table = table[parent]
        table[leaf] = value
        return settings

    return change
