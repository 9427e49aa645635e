"""Steps of each policy divided by those of a baseline, on the maps of each kind and of each source."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from indoor_explorers.evaluation.harness.results.map_labels import unit_of
from indoor_explorers.evaluation.harness.results.origins import maps_by_origin
from indoor_explorers.evaluation.harness.results.ratios import COLUMNS, Ratios
from indoor_explorers.evaluation.harness.results.results import write_csv

#: The columns of ratios_by_origin.csv.
ORIGIN_COLUMNS = ("maps_of", "maps", *COLUMNS)


class OriginRatios(NamedTuple):
    """Ratios on the maps of one kind or source."""

    title: str
    """Such as ``kind: hall``."""
    maps: int
    units: int
    """Number of buildings or layouts that the maps are of, which intervals resample."""
    unit: str
    """What maps with one label share: ``building`` or ``layout``."""
    ratios: Ratios


def ratios_by_origin(ratios: Ratios) -> list[OriginRatios]:
    """Return the ratios on the maps of each kind, then of each source; empty where there is one of each."""
    results, found = ratios.results, []
    for title, maps in maps_by_origin(results.origins, [each.floorplan.digest for each in results.records]).items():
        part = replace(results, records=[each for each in results.records if each.floorplan.digest in maps])
        labels = {str(label) for key in part.groups for label in part.maps(*key)}
        found.append(OriginRatios(title, len(maps), len(labels), unit_of(labels), Ratios(part, ratios.to)))
    return found


def write_origin_ratios(parts: list[OriginRatios], path: Path) -> None:
    """Write ratios_by_origin.csv: the rows of ratios.csv for each kind and source; equal results give equal bytes."""
    rows = [{"maps_of": part.title, "maps": part.maps, **row.cells()} for part in parts for row in part.ratios.rows]
    write_csv(pd.DataFrame(rows, columns=list(ORIGIN_COLUMNS)), path, "%.6g")
