"""Make a large store of a small one, to see what a report of many episodes costs.

    python -P -m indoor_explorers.evaluation.site.studies.large_store SOURCE TARGET TIMES

copies each episode of the folder SOURCE, which ``compare`` wrote, under other seeds into the new folder TARGET, so that
it has TIMES as many. ``evaluation/CLUSTER.md`` reports such stores.
"""

from __future__ import annotations

import re
import shutil
import sqlite3
import sys
from contextlib import closing
from pathlib import Path

from indoor_explorers.evaluation.harness.results.rows import Row, checksum


def enlarge(source: Path, target: Path, times: int) -> None:
    """Write ``target/results.db`` with the episodes of ``source/results.db``, each under ``times`` seeds."""
    target.mkdir(parents=True)
    with closing(sqlite3.connect(shutil.copy(source / "results.db", target))) as db, db:
        flown = db.execute("SELECT * FROM episode").fetchall()
        seeds = 1 + max(row[3] for row in flown) - min(row[3] for row in flown)
        for copy in range(1, times):
            for row in flown:
                _replace(db, "episode", (*row[:3], row[3] + copy * seeds, *row[4:]))
        for run, facts, experiment in db.execute("SELECT * FROM run").fetchall():
            _replace(db, "run", (run, facts, re.sub(r"(?m)^episodes = \d+", f"episodes = {seeds * times}", experiment)))


def _replace(db: sqlite3.Connection, table: str, row: Row) -> None:
    db.execute(f"REPLACE INTO {table} VALUES ({', '.join('?' * len(row))})", row)
    db.execute("INSERT INTO checksum VALUES (?)", (checksum(table, row),))


if __name__ == "__main__":
    enlarge(Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]))
