"""The shipped suites, a TOML file each, ``NAME-VERSION.toml``; older versions stay for their results."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from indoor_explorers.env.errors import InputError, did_you_mean
from indoor_explorers.env.maps.base import BaseMaps
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.sources import FileMaps
from indoor_explorers.env.scenarios.suites.suite import Part, Suite
from indoor_explorers.env.scenarios.validation import read_toml, validated

#: The folder of the files.
FOLDER = Path(__file__).parent


@lru_cache(maxsize=1)
def all_suites() -> tuple[Suite, ...]:
    """Return every version of every suite by name, the latest version of each first, those of listed scenarios last.

    Results that are of two suites, as those of a single scenario of the last ones can be, are thus of the first.
    """
    found = [validated(Suite, read_toml(path), path.name) for path in FOLDER.glob("*.toml")]
    return tuple(sorted(found, key=lambda suite: (bool(suite.listed), suite.name, -suite.version)))


def suites() -> dict[str, Suite]:
    """Return the latest version of each suite by name."""
    found: dict[str, Suite] = {}
    for suite in all_suites():
        found.setdefault(suite.name, suite)
    return found


def suite_of(name: str) -> Suite:
    """Return the latest version of a suite; raise :class:`InputError` if there is no suite of that name."""
    known = suites()
    if name not in known:
        raise InputError(f"unknown suite {name!r}{did_you_mean(name, known)}")
    return known[name]


@lru_cache(maxsize=1)
def buildings() -> dict[str, str]:
    """Return suite and building of each map of a file by its digest, such as ``floors: GDC``."""
    return {
        each.digest: f"{suite.name}: {each.building}"
        for suite in reversed(all_suites())
        for home in suite.repositories
        for each in home.maps
    }


@lru_cache(maxsize=1)
def repositories() -> dict[str, str]:
    """Return the name of the repository of each map of a file by its digest, such as ``amrl_maps``."""
    return {each.digest: home.name for suite in all_suites() for home in suite.repositories for each in home.maps}


def source_of(maps: BaseMaps, index: int, plan: Floorplan) -> str:
    """Return where map ``index`` of some maps is from: a suite's repository, else its file's folder or the generator.

    Args:
        maps: the maps.
        index: the number of the map among them; any where they are generated.
        plan: the map.

    """
    if plan.digest in repositories():
        return repositories()[plan.digest]
    return Path(maps.paths[index]).resolve().parent.name if isinstance(maps, FileMaps) else plan.name


def digests_of(name: str) -> list[str]:
    """Return the digests of maps and layouts of a part, such as ``floors/train``; a digest stays as it is.

    All versions of the suite count.

    Raises:
        InputError: there is no suite or no part of that name, the part has no maps, or they are generated from seeds.

    """
    title, slash, part = name.partition("/")
    if not slash:
        return [name]
    suite = suite_of(title)
    if part not in list(Part) or suite.generated or not suite.has(Part(part)):
        raise InputError(f"expected a part of a suite of map files, such as 'floors/train', got {name!r}")
    mine = (each for each in all_suites() if each.name == title)
    entries = [entry for each in mine for _, entry in each.maps(Part(part))]
    return list(dict.fromkeys(digest for entry in entries for digest in (entry.digest, entry.layout)))
