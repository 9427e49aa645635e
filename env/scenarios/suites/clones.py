"""Find the map files of a suite in clones of their repositories, and verify their checksums."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Sequence
from fnmatch import fnmatchcase
from pathlib import Path

from indoor_explorers.env.errors import InputError, did_you_mean
from indoor_explorers.env.maps.sources import FileMaps, MapSource
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.scenarios.suites.suite import Part, Repository, Suite, SuiteMap, digest_of

Located = tuple[Repository, SuiteMap, Path | None]


def located(suite: Suite, part: Part, data: Iterable[Path]) -> Iterator[Located]:
    """Yield the map files of a part, each with the folder of the clone that has it; None where none does.

    Of several folders that have files of these names the first one with the suite's checksums counts.

    Args:
        suite: the suite.
        part: the part.
        data: clones, or folders that clones are in.

    """
    roots = [root for folder in data for root in (folder, *_subfolders(folder))]
    for home, each in suite.maps(part):
        inside = [root / home.folder for root in roots]
        found = [root for root in inside if all((root / path).is_file() for path in each.files)]
        whole = (root for root in found if len(found) == 1 or not any(_changed(each, root)))
        yield home, each, next(whole, found[0] if found else None)


def _subfolders(folder: Path) -> list[Path]:
    try:
        return sorted(entry for entry in folder.iterdir() if entry.is_dir())
    except OSError:
        return []


def how_to_fetch(home: Repository) -> str:
    """Return the command that clones a repository at the commit of a suite."""
    return f"git clone {home.url} && git -C {home.name} checkout {home.commit}"


def scenarios_of(
    suite: Suite,
    part: Part,
    data: Sequence[Path],
    *,
    only: Sequence[str] = (),
    teams: Iterable[int] | None = None,
    radios: Iterable[str] | None = None,
    names: Sequence[str] | None = None,
) -> list[Scenario]:
    """Return the scenarios of a part with their maps, all of them or those of some teams, radios and names.

    Raises:
        InputError: as :func:`maps_of`; or a name is no scenario of the suite.

    """
    maps = None if suite.listed else maps_of(suite, part, data, only)
    known = {each.name: each for each in suite.scenarios(maps, teams, radios)}
    for name in names or ():
        if name not in known:
            raise InputError(f"suite {suite.name!r} has no scenario {name!r}{did_you_mean(name, known)}")
    chosen = [each for name, each in known.items() if names is None or name in names]
    if suite.listed:
        _refuse_absent(suite, part)
        _refuse_choice(suite, only)
        _check_generators(suite, part, chosen)
    return chosen


def _check_generators(suite: Suite, part: Part, scenarios: Iterable[Scenario]) -> None:
    found: dict[str, str] = {}
    for each in scenarios:
        key, entry = each.map.model_dump_json(), suite.listed[each.name.removeprefix(f"{suite.name}-")]
        if key not in found:
            found[key] = digest_of(each.map, suite.seeds(part))
        _refuse_other_map(suite, f"the {part} part of {each.name}", entry.digests[part], found[key])


def maps_of(suite: Suite, part: Part, data: Sequence[Path], only: Sequence[str] = ()) -> MapSource:
    """Return the source of the maps of a part, all of them or those whose names or buildings match a pattern.

    Raises:
        InputError: the suite lacks the part or has several generators, files are missing or differ from the suite's, or
            maps are read or drawn differently.

    """
    _refuse_absent(suite, part)
    if suite.listed:
        raise InputError(f"suite {suite.name!r} has maps of several generators; name a scenario of it instead")
    if suite.map is not None:
        return _checked_generator(suite, part, only)
    found = _matching(suite, part, list(located(suite, part, data)), only)
    _refuse_missing(suite, found)
    paths = []
    for home, each, root in found:
        assert root is not None
        _check_files(home, each, root)
        paths.append(str(root / each.path))
    maps = FileMaps(paths=tuple(paths), resolution=suite.resolution, least_levels=suite.levels.get(part, 1))
    for index, (_, each, _) in enumerate(found):
        _refuse_other_map(suite, each.name, each.digest, maps.floorplan(index, 0).digest)
    return maps


def _checked_generator(suite: Suite, part: Part, only: Sequence[str]) -> MapSource:
    assert suite.map is not None
    _refuse_choice(suite, only)
    digest = digest_of(suite.map, suite.seeds(part))
    _refuse_other_map(suite, f"its {part} part", suite.parts[part].digest, digest)
    return suite.map


def _refuse_absent(suite: Suite, part: Part) -> None:
    if not suite.has(part):
        parts = " or ".join(each for each in Part if suite.has(each))
        raise InputError(f"suite {suite.name!r} has no {part} part; ask for its {parts} part")


def _refuse_choice(suite: Suite, only: Sequence[str]) -> None:
    if only:
        raise InputError(f"suite {suite.name!r} generates its maps; leave --maps out, or ask for fewer --episodes")


def _matching(suite: Suite, part: Part, found: list[Located], only: Sequence[str]) -> list[Located]:
    """Return the maps that match one of the patterns, in the order of the suite."""
    for pattern in only:
        if not any(_matches(each, pattern) for _, each, _ in found):
            names = {word for _, each, _ in found for word in (each.name, each.building)}
            raise InputError(
                f"no map {pattern!r} in the {part} part of suite {suite.name!r}{did_you_mean(pattern, names)}"
            )
    return [entry for entry in found if not only or any(_matches(entry[1], pattern) for pattern in only)]


def _matches(each: SuiteMap, pattern: str) -> bool:
    return fnmatchcase(each.name, pattern) or fnmatchcase(each.building, pattern)


def _refuse_missing(suite: Suite, found: Iterable[Located]) -> None:
    lacking: dict[str, tuple[Repository, list[str]]] = {}
    for home, each, root in found:
        if root is None:
            lacking.setdefault(home.url, (home, []))[1].append(home.folder + each.path)
    if lacking:
        told = "; ".join(
            f"{len(paths)} of {home.name}, such as {paths[0]}: {how_to_fetch(home)}" for home, paths in lacking.values()
        )
        raise InputError(f"suite {suite.name!r} lacks map files below --data: {told}")


def _check_files(home: Repository, each: SuiteMap, root: Path) -> None:
    for path, digest in _changed(each, root):
        raise InputError(
            f"{root / path}: expected the file of commit {home.commit[:12]} (SHA-256 {each.files[path][:12]}...), "
            f"got another one ({digest[:12]}...); {how_to_fetch(home)}"
        )


def _changed(each: SuiteMap, root: Path) -> Iterator[tuple[str, str]]:
    """Yield paths and SHA-256 of a map's files that are not the suite's."""
    for path, expected in each.files.items():
        digest = hashlib.sha256((root / path).read_bytes()).hexdigest()
        if digest != expected:
            yield path, digest


def _refuse_other_map(suite: Suite, what: str, expected: str, got: str) -> None:
    if got != expected:
        raise InputError(
            f"suite {suite.title}: {what} is not what it was when the suite was made (expected digest {expected}, got "
            f"{got}), as this version of the package reads or draws maps in another way; results would not compare"
        )
