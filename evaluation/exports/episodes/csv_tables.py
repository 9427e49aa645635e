"""An episode as CSV: ``steps.csv``, a row for each UAV and step, and ``meta.json``."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from indoor_explorers.env import Scenario
from indoor_explorers.evaluation.exports.episodes.moments import facts_of, frame_of, moments
from indoor_explorers.evaluation.harness.episodes.record import Record

#: The columns of ``steps.csv``. ``action`` led to this step and is empty at the start; ``linked`` lists teammates.
COLUMNS = (
    *("step", "uav", "flew", "row", "col", "x", "y", "action", "discovered", "received", "team_coverage", "linked"),
)
#: More columns of a map of several levels, each before another one; ``row`` is then that on the level.
LEVEL_COLUMNS = {"level": "row", "z": "action"}
#: The files of an export.
FILES = ("steps.csv", "meta.json")


def write_csv(record: Record, scenario: Scenario, folder: Path, step_seconds: float) -> None:
    """Write the two files into an empty folder; equal episodes give equal bytes."""
    steps, meta = (folder / name for name in FILES)
    with steps.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        columns = columns_of(several=record.floorplan.level_count > 1)
        writer.writerow(columns)
        writer.writerows([row[name] for name in columns] for row in _rows(record, scenario))
    about = facts_of(record, step_seconds) | {"metrics": record.metrics, "settings": scenario.model_dump(mode="json")}
    meta.write_text(json.dumps(about, indent=2) + "\n", "utf-8")


def columns_of(*, several: bool) -> tuple[str, ...]:
    """Return the columns of ``steps.csv`` on a map of one level or of ``several``."""
    before = {column: more for more, column in LEVEL_COLUMNS.items()} if several else {}
    return tuple(name for column in COLUMNS for name in (before.get(column), column) if name)


def _rows(record: Record, scenario: Scenario) -> Iterator[dict[str, Any]]:
    frame = frame_of(record)
    for moment in moments(record, scenario):
        for uav, cell in enumerate(moment.cells):
            level, row, col = frame.levels.voxels(cell).tolist()
            x, y, z = (round(metres, 6) for metres in frame.place(cell.tolist()))
            action = int(record.actions[moment.step - 1, uav]) if moment.step else ""
            found = {"discovered": int(moment.discovered[uav]), "received": int(moment.received[uav])}
            yield {
                **{"step": moment.step, "uav": uav, "flew": int(moment.flew[uav]), "level": level, "row": row},
                **{"col": col, "x": x, "y": y, "z": z, "action": action, **found},
                "team_coverage": round(moment.coverage, 6),
                "linked": " ".join(map(str, np.flatnonzero(moment.linked[uav]))),
            }
