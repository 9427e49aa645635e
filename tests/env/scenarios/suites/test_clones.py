"""Map files of a suite: found in clones, checked, and each fault told in one line."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from indoor_explorers.env import InputError
from indoor_explorers.env.scenarios.suites.catalogue import suite_of
from indoor_explorers.env.scenarios.suites.clones import located, maps_of
from indoor_explorers.env.scenarios.suites.suite import Part
from tests.suites import tiny, tiny_clones

__all__ = ["tiny", "tiny_clones"]


def names(maps) -> list[str]:
    return [maps.floorplan(index, 0).name for index in range(maps.count)]


def test_clones_are_found_by_themselves_and_in_a_folder(tiny: Path):
    suite = suite_of("tiny")
    assert names(maps_of(suite, Part.TEST, [tiny])) == ["a1", "a2", "b"]
    assert names(maps_of(suite, Part.TEST, [tiny / "plans", tiny / "floors"])) == ["a1", "a2", "b"]
    assert names(maps_of(suite, Part.TRAIN, [tiny / "plans"])) == ["d"]


def test_of_clones_with_files_of_one_name_the_one_with_the_checksums_counts(tiny: Path, tmp_path: Path):
    for name in ("aaa", "zzz"):
        shutil.copytree(tiny / "floors", tmp_path / name)
        np.save(tmp_path / name / "a1.npy", np.zeros((5, 5), np.int8))
    assert names(maps_of(suite_of("tiny"), Part.TEST, [tmp_path, tiny])) == ["a1", "a2", "b"]
    with pytest.raises(InputError, match=r"aaa/a1\.npy: expected the file of commit"):
        maps_of(suite_of("tiny"), Part.TEST, [tmp_path])


def test_a_part_that_a_suite_lacks_is_told():
    with pytest.raises(InputError, match="suite 'buildings' has no train part; ask for its test part"):
        maps_of(suite_of("buildings"), Part.TRAIN, [])


def test_maps_are_chosen_by_name_and_by_building(tiny: Path):
    def chosen(*only: str) -> list[str]:
        return names(maps_of(suite_of("tiny"), Part.TEST, [tiny], only))

    assert chosen("A") == chosen("a*") == ["a1", "a2"]
    assert chosen("b", "a1") == ["a1", "b"]
    with pytest.raises(InputError, match="no map 'c' in the test part of suite 'tiny'"):
        chosen("a1", "c")


def test_a_map_flown_alone_has_the_levels_of_its_part(tiny: Path):
    suite = suite_of("tiny").model_copy(update={"levels": {Part.TEST: 3}})
    assert maps_of(suite, Part.TEST, [tiny], ["b"]).level_count == 3
    assert maps_of(suite, Part.TRAIN, [tiny]).level_count == 1


def test_missing_files_are_told_with_the_commands_that_fetch_them(tiny: Path, tmp_path: Path):
    with pytest.raises(InputError) as told:
        maps_of(suite_of("tiny"), Part.TEST, [tmp_path / "nowhere"])
    assert str(told.value) == (
        "suite 'tiny' lacks map files below --data: 3 of floors, such as a1.npy: git clone "
        f"https://example.org/us/floors && git -C floors checkout {'f' * 40}"
    )
    with pytest.raises(InputError, match=r"lacks map files below --data: 1 of plans, such as deep/d\.npy: git clone"):
        maps_of(suite_of("tiny"), Part.TRAIN, [tiny / "floors"])
    assert [root is None for _, _, root in located(suite_of("tiny"), Part.TEST, [tiny])] == [False] * 3


def test_a_changed_file_is_refused_with_the_commit_to_check_out(tiny: Path, tmp_path: Path):
    copy = shutil.copytree(tiny, tmp_path / "copy")
    np.save(copy / "plans" / "deep" / "d.npy", np.zeros((5, 5), np.int8))
    with pytest.raises(InputError, match=r"deep/d\.npy: expected the file of commit p{12} \(SHA-256 .*checkout p{40}"):
        maps_of(suite_of("tiny"), Part.TRAIN, [copy])
    assert names(maps_of(suite_of("tiny"), Part.VALIDATION, [copy])) == ["c"]


def test_a_map_that_is_read_in_another_way_is_refused(tiny: Path):
    coarser = suite_of("tiny").model_copy(update={"resolution": 2.0})
    with pytest.raises(InputError, match="suite tiny 3: d is not what it was when the suite was made"):
        maps_of(coarser, Part.TRAIN, [tiny])


def test_a_generator_that_draws_other_maps_is_refused():
    rooms = suite_of("rooms")
    assert maps_of(rooms, Part.TEST, []) == rooms.map
    changed = rooms.model_copy(update={"map": rooms.map.model_copy(update={"obstacles": 4})})
    with pytest.raises(InputError, match="suite rooms 1: its test part is not what it was"):
        maps_of(changed, Part.TEST, [])
    with pytest.raises(InputError, match="suite 'rooms' generates its maps; leave --maps out"):
        maps_of(rooms, Part.TEST, [], ["a"])
