"""The source and the kind of maps, stored when an experiment is flown, and the maps that share either."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from indoor_explorers.env import Scenario
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.kinds import kind_of
from indoor_explorers.env.scenarios.suites.catalogue import source_of


class Origin(NamedTuple):
    """The source and the kind of a map."""

    source: str
    """A repository, a folder of files, or the name of a generator."""
    kind: str
    """Its :class:`~indoor_explorers.env.maps.kinds.Kind` by the version of the package that flew on it first."""

    @classmethod
    def of(cls, scenario: Scenario, index: int, plan: Floorplan) -> Origin:
        """Return the origin of map ``index`` of a scenario."""
        return cls(source_of(scenario.map, index, plan), str(kind_of(plan)))


def maps_by_origin(origins: Mapping[str, Origin], flown: Sequence[str]) -> dict[str, frozenset[str]]:
    """Return which of the ``flown`` maps are of each kind and of each source, by titles such as ``kind: hall``.

    Maps are digests. Kinds are left out where all maps are of one, and so are sources; empty where the origin of a map
    is not known, as in stores of older versions.
    """
    found: dict[str, frozenset[str]] = {}
    if all(digest in origins for digest in flown):
        for field in ("kind", "source"):
            of_map = {digest: str(getattr(origins[digest], field)) for digest in flown}
            values = sorted(set(of_map.values()))
            for value in values if len(values) > 1 else ():
                found[f"{field}: {value}"] = frozenset(digest for digest in flown if of_map[digest] == value)
    return found
