"""Which maps count as one where maps are counted or drawn: floors of one building, and maps with one layout."""

from __future__ import annotations

from collections.abc import Iterable

from indoor_explorers.env.scenarios.suites.catalogue import buildings
from indoor_explorers.evaluation.harness.episodes.record import Record


def map_labels(records: Iterable[Record], scenario: str, source: str) -> dict[str, str]:
    """Return the labels of a scenario's maps by their digests; maps that count as one have one label.

    The label of a floor that a suite knows is its building. Map files with one layout, such as turned ones and those
    with other starts, have the digest of the first. Layouts of maps of another ``source``,
    which are generated, are not compared.
    """
    known, first, labels = buildings(), dict[str, str](), dict[str, str]()
    for plan in (record.floorplan for record in records if record.task.scenario == scenario):
        if plan.digest not in labels:
            alike = first.setdefault(plan.layout, plan.digest) if source == "files" else plan.digest
            labels[plan.digest] = known.get(plan.digest, alike)
    return labels


def unit_of(labels: Iterable[str]) -> str:
    """Return what maps with one label share: a building, or a layout where no suite knows any of them."""
    return "layout" if set(buildings().values()).isdisjoint(labels) else "building"
