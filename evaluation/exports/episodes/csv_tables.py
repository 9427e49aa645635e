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
#: The files of an export.
FILES = ("steps.csv", "meta.json")


def write_csv(record: Record, scenario: Scenario, folder: Path, step_seconds: float) -> None:
    """Write the two files into an empty folder; equal episodes give equal bytes."""
    steps, meta = (folder / name for name in FILES)
    with steps.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(_rows(record, scenario))
    about = facts_of(record, step_seconds) | {"metrics": record.metrics, "settings": scenario.model_dump(mode="json")}
    meta.write_text(json.dumps(about, indent=2) + "\n", "utf-8")


def _rows(record: Record, scenario: Scenario) -> Iterator[tuple[Any, ...]]:
    frame = frame_of(record)
    for moment in moments(record, scenario):
        for uav, (row, col) in enumerate(moment.cells.tolist()):
            x, y = frame.point((row, col))
            yield (
                *(moment.step, uav, int(moment.flew[uav]), row, col, round(x, 6), round(y, 6)),
                int(record.actions[moment.step - 1, uav]) if moment.step else "",
                *(int(moment.discovered[uav]), int(moment.received[uav]), round(moment.coverage, 6)),
                " ".join(map(str, np.flatnonzero(moment.linked[uav]))),
            )
