"""The suites that ship: their parts share nothing, and their maps are what the files say."""

import hashlib
import json
import os
import re
from collections.abc import Iterable
from itertools import combinations
from pathlib import Path

import pytest

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.maps.files import read_map
from indoor_explorers.env.scenarios.seed_sets import SeedUse, use_of
from indoor_explorers.env.scenarios.suites.catalogue import FOLDER, all_suites, buildings, digests_of, suite_of, suites
from indoor_explorers.env.scenarios.suites.clones import how_to_fetch, maps_of
from indoor_explorers.env.scenarios.suites.suite import Part, Repository, Suite, digest_of
from tests.marks import slow

DOCUMENT = (Path(__file__).parents[4] / "evaluation" / "SUITES.md").read_text()
SHARED = Path(__file__).parents[5] / "shared" / "maps"
#: Shared maps: the suite's resolution, and files of which some are in the suite.
FOLDERS = {
    "floors": (0.5, [*(SHARED / "floors").glob("*.yaml"), *(SHARED / "slam").glob("[SUg]*.yaml")]),
    "dungeons": (4.0, [*(SHARED / "dungeon").glob("*.png")]),
}
#: The repositories' clones, where there are any.
CLONES = Path(os.environ.get("SUITE_DATA", "no-folder"))
USES = {Part.TRAIN: SeedUse.TRAINING, Part.VALIDATION: SeedUse.VALIDATION, Part.TEST: SeedUse.TEST}
#: Suites for a final test alone.
FINAL = {"buildings"}
#: The parts of suites that lack some.
PARTS = {"buildings": {Part.TEST}, "atlas": {Part.VALIDATION, Part.TEST}, "rmf": {Part.VALIDATION, Part.TEST}}
#: Suites whose maps are of buildings that may have several floors.
BUILDINGS = {"buildings", "floors"}
#: Repositories whose maps this project had met before the suite buildings was made, in suites or elsewhere.
MET = {
    "aislabunimi",
    "castacks/MapEx",
    "goldleaf3i",
    "marmotlab",
    "nathansttt/hog2",
    "pierrebrd/exploration_benchmarking",
    "RobustFieldAutonomyLab/DRL_robot_exploration",
    "ros-navigation/navigation2",
    "ut-amrl",
}
#: What each version of each suite holds.
CONTENTS = {
    "buildings 1": "3b9c4947a287ded1",
    "dare 1": "9bca31f69c5e25f4",
    "dungeons 1": "5a5c4c30a7b389f1",
    "floors 1": "a770d13394c06bed",
    "floors-generated 1": "b867267fe6de98b5",
    "ir2-complex 1": "a3e599c324e0b056",
    "ir2-corridor 1": "f751487f1c129efa",
    "ir2-hybrid 1": "69b6f5d0dc25690e",
    "rmf 1": "dd76ee1d6f72ccf5",
    "rooms 1": "b501cb3e625b5e57",
    "atlas 1": "2288a09cc7d340cf",
    "levels 1": "e54dc2eb73903b68",
}
ALL = pytest.mark.parametrize("suite", all_suites(), ids=lambda suite: suite.title)


def test_these_suites_ship():
    assert [f"{suite.name} {suite.version}" for suite in suites().values()] == list(CONTENTS)
    assert {f"{suite.name}-{suite.version}.toml" for suite in all_suites()} == {
        file.name for file in FOLDER.glob("*.toml")
    }


@ALL
def test_a_suite_never_changes(suite: Suite):
    """Of what was published, another version is made: ``NAME-VERSION.toml`` beside the old file."""
    assert contents(suite) == CONTENTS[suite.title]


def contents(suite: Suite) -> str:
    """A hash of all tasks of a suite: settings that are not defaults, seeds, and maps with their buildings."""
    settings = [
        scenario.model_dump(mode="json", exclude_defaults=True, exclude={"map"}) for scenario in suite.scenarios()
    ]
    maps = {part: [(each.building, each.digest) for _, each in suite.maps(part)] for part in Part}
    seeds = {part: [*suite.seeds(part)[:1], len(suite.seeds(part))] for part in Part}
    drawn: dict[str, object] = {part: each.digest for part, each in suite.parts.items()}
    drawn |= {name: each.digests for name, each in suite.listed.items()}
    levels = [suite.levels] if suite.levels else []
    told = json.dumps([settings, maps, seeds, drawn, suite.resolution, *levels], sort_keys=True)
    return hashlib.sha256(told.encode()).hexdigest()[:16]


@ALL
def test_parts_share_no_building_no_map_and_no_seed(suite: Suite):
    for one, other in combinations(Part, 2):
        assert not suite.buildings(one) & suite.buildings(other)
        assert not set(suite.seeds(one)) & set(suite.seeds(other))
    every = [each for home in suite.repositories for each in home.maps]
    for values in (
        [each.digest for each in every],
        [each.layout for each in every],
        [sha for each in every for sha in each.files.values()],
    ):
        assert len(values) == len(set(values))
    assert {each.part for each in every} == (set() if suite.generated else parts_of(suite))


def parts_of(suite: Suite) -> set[Part]:
    """The parts that a suite must have."""
    return PARTS.get(suite.name, set(Part))


@ALL
def test_a_part_is_flown_on_seeds_of_its_use(suite: Suite):
    assert {part for part in Part if suite.has(part)} == parts_of(suite)
    for part in Part:
        assert (suite.map_count(part) > 0) is suite.has(part)
    for part in parts_of(suite) if suite.generated else Part:
        assert use_of(suite.seeds(part)) is USES[part]


@ALL
def test_numbers_of_levels_are_of_parts_of_map_files(suite: Suite):
    assert set(suite.levels) <= (set() if suite.generated else parts_of(suite))
    assert all(number > 1 for number in suite.levels.values())


@ALL
def test_checksums_and_names_are_whole(suite: Suite):
    assert set(suite.parts) == (parts_of(suite) if suite.generated else set())
    assert all(bool(part.digest) is not bool(suite.listed) for part in suite.parts.values())
    assert all(set(each.digests) == parts_of(suite) for each in suite.listed.values())
    for home in suite.repositories:
        assert home.url.startswith("https://github.com/")
        assert len(home.commit) == 40
        assert not home.folder or home.folder.endswith("/")
        assert all(len(sha) == 64 for each in home.maps for sha in each.files.values())
        assert all(len(each.digest) == 16 and each.cells >= 150 for each in home.maps)
        assert len({each.name for each in home.maps}) == len(home.maps)  # --maps names one


def test_some_teams_and_radios_of_a_suite():
    def names(**chosen) -> list[str]:
        return [scenario.name for scenario in suite_of("floors").scenarios(**chosen)]

    assert names(teams=[1]) == ["floors-1"]
    assert names(teams=[2, 4], radios=["disc"]) == ["floors-2-disc", "floors-4-disc"]
    assert names(radios=["none"]) == ["floors-1", "floors-2-none", "floors-4-none"]


@pytest.mark.parametrize("name", ["rooms", "floors-generated"])
def test_generators_draw_the_maps_that_the_suites_have(name: str):
    suite = suite_of(name)
    assert suite.map is not None
    assert digest_of(suite.map, suite.seeds(Part.VALIDATION)) == suite.parts[Part.VALIDATION].digest


@pytest.mark.parametrize(("name", "teams"), [("atlas", [2, 8]), ("levels", [4])])
def test_generators_draw_the_maps_that_listed_scenarios_have(name: str, teams: list[int]):
    suite = suite_of(name)
    for scenario in suite.scenarios(teams=teams):
        entry = suite.listed[scenario.name.removeprefix(f"{name}-")]
        assert digest_of(scenario.map, suite.seeds(Part.VALIDATION)) == entry.digests[Part.VALIDATION]


def test_teams_of_the_suite_of_levels_fly_the_same_buildings():
    levels = suite_of("levels")
    for name, entry in levels.listed.items():
        assert entry.digests == levels.listed[f"{name.rpartition('-')[0]}-1"].digests
    assert {each.team for each in levels.scenarios()} == {1, 2, 4}
    assert all(each.map.level_count > 1 for each in levels.scenarios())


@pytest.mark.parametrize("name", ["rooms", *slow("floors-generated")])
def test_no_map_to_test_on_is_a_turned_mirrored_or_rescaled_one_to_train_on(name: str):
    suite = suite_of(name)
    assert suite.map is not None
    drawn = {part: {suite.map.floorplan(0, seed).layout for seed in suite.seeds(part)} for part in Part}
    for one, other in combinations(Part, 2):
        assert not drawn[one] & drawn[other]
    assert sum(map(len, drawn.values())) == sum(part.maps for part in suite.parts.values())


@pytest.mark.parametrize("name", sorted(FINAL))
def test_a_final_test_has_maps_of_sources_that_nothing_met_before(name: str):
    mine = suite_of(name)
    sources = {home.url.removeprefix("https://github.com/") for home in mine.repositories}
    others = [home for suite in all_suites() if suite.name not in FINAL for home in suite.repositories]
    assert len(sources) >= 3
    assert not [each for each in sources for met in MET if each == met or each.startswith(f"{met}/")]
    assert not sources & {home.url.removeprefix("https://github.com/") for home in others}
    assert not checksums(mine.repositories) & checksums(others)
    assert len(mine.buildings(Part.TEST)) >= 20


def checksums(homes: Iterable[Repository]) -> set[str]:
    """Digests, layouts and SHA-256 of all files of some repositories."""
    maps = [each for home in homes for each in home.maps]
    return {told for each in maps for told in (each.digest, each.layout, *each.files.values())}


@pytest.mark.slow
@pytest.mark.skipif(not SHARED.is_dir(), reason="../shared/maps is not there")
def test_no_map_of_a_final_test_is_one_that_the_project_was_developed_on():
    folders = [SHARED / name for name in ("floors", "kth", "newfloors", "slam")]
    files = [path for folder in folders for path in folder.glob("*.yaml") if "wrong" not in path.name]
    plans = [read_map(path, 0.5) for path in files]
    for name in FINAL:
        assert not {told for plan in plans for told in (plan.digest, plan.layout)} & set(digests_of(f"{name}/test"))


def test_an_unknown_suite_is_told_with_the_nearest_one():
    with pytest.raises(InputError, match="unknown suite 'flors'; did you mean 'floors'"):
        suite_of("flors")


def test_parts_stand_for_their_maps_and_digests_for_themselves():
    assert digests_of("0123") == ["0123"]
    assert len(digests_of("floors/train")) == 2 * suite_of("floors").map_count(Part.TRAIN)  # maps and layouts
    assert not set(digests_of("floors/train")) & set(digests_of("floors/test"))
    for name in ("floors/tests", "rooms/train", "flors/train", "buildings/train"):
        with pytest.raises(InputError, match=name.partition("/")[0]):
            digests_of(name)


def test_floors_of_one_building_have_one_label():
    floors = {each.name: buildings()[each.digest] for _, each in suite_of("floors").maps(Part.TRAIN)}
    assert floors["GDC3"] == floors["GDC4"] == "floors: GDC"
    assert floors["GDC3"] != floors["ED21"]


def test_manifests_that_have_maps_twice_or_not_at_all_are_refused():
    told = suite_of("rooms").model_dump(by_alias=True, exclude={"map"})
    with pytest.raises(ValueError, match="needs one of map files of repositories, a generator, and scenarios"):
        Suite.model_validate(told)
    listed = suite_of("atlas").model_dump(by_alias=True)
    assert Suite.model_validate(listed) == suite_of("atlas")
    with pytest.raises(ValueError, match="needs one of"):
        Suite.model_validate(listed | {"map": suite_of("rooms").map})


@pytest.mark.parametrize("name", FOLDERS)
@pytest.mark.skipif(not SHARED.is_dir(), reason="../shared/maps is not there")
def test_shared_maps_are_in_no_test_part(name: str):
    resolution, files = FOLDERS[name]
    known = {each.digest: each.part for _, each in ((h, e) for h in suite_of(name).repositories for e in h.maps)}
    parts = [known.get(read_map(file, resolution).digest) for file in sorted(files)[::8]]
    assert set(parts) == {Part.TRAIN, Part.VALIDATION}


@pytest.mark.slow
@pytest.mark.parametrize("name", FOLDERS)
@pytest.mark.skipif(not SHARED.is_dir(), reason="../shared/maps is not there")
def test_the_shared_maps_are_the_train_and_validation_parts(name: str):
    resolution, files = FOLDERS[name]
    mine = {digest for part in (Part.TRAIN, Part.VALIDATION) for digest in digests_of(f"{name}/{part}")}
    plans = [read_map(file, resolution) for file in files]
    assert {digest for plan in plans for digest in (plan.digest, plan.layout)} == mine


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "part"), [(name, part) for name in (*FOLDERS, *FINAL, "rmf") for part in Part if suite_of(name).has(part)]
)
@pytest.mark.skipif(not CLONES.is_dir(), reason="SUITE_DATA names no folder of clones")
def test_the_files_of_the_repositories_are_read_as_the_suites_have_them(name: str, part: Part):
    suite = suite_of(name)
    maps = maps_of(suite, part, [CLONES])
    plans = [maps.floorplan(index, 0) for index in range(maps.count)]
    facts = [(int(plan.main_part.sum()), plan.layout) for plan in plans]
    assert facts == [(each.cells, each.layout) for _, each in suite.maps(part)]
    assert maps.level_count == suite.levels.get(part, 1) == max(plan.level_count - plan.added for plan in plans)
    assert all(isinstance(scenario, Scenario) for scenario in suite.scenarios(maps))


def test_the_document_has_the_numbers_of_the_suites():
    rows = re.findall(
        r"^\| `([\w-]+)` \|.*?\| (\d+ / \d+ / \d+) \| ([\d/ -]+) \| (\d+) \| ([\d,]+) \|", DOCUMENT, re.MULTILINE
    )
    told = {
        name: (maps, buildings, int(starts), int(tasks.replace(",", "")))
        for name, maps, buildings, starts, tasks in rows
    }
    assert told == {
        name: (
            " / ".join(str(suite.map_count(part)) for part in Part),
            " / ".join(str(len(suite.buildings(part))) for part in Part) if name in BUILDINGS else "-",
            suite.starts,
            suite.task_count(Part.TEST),
        )
        for name, suite in suites().items()
    }
    for suite in all_suites():
        assert all(how_to_fetch(home) in DOCUMENT for home in suite.repositories)
