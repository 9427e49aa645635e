"""Readers of map files as plug-ins: maps count by their cells, and no UAV is told the files."""

import numpy as np
import pytest

from indoor_explorers.env import InputError, MapReader, Scenario, World, scenario


class Tables(MapReader):
    """Text files of 0 for free cells and 1 for walls."""

    free: str = "0"
    """The character of free cells."""

    def read(self, path):
        return np.array([list(line) for line in path.read_text().split()]) == self.free


ROOM = "11111\n10001\n10001\n11111\n"


@pytest.fixture
def files(tmp_path):
    for name in ("one", "other"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "room.txt").write_text(ROOM)
    (tmp_path / "larger.txt").write_text(ROOM.replace("10001", "10001\n10001"))
    return tmp_path


def task(*paths):
    maps = {"map.source": f"{__name__}:Tables", "map.paths": [str(path) for path in paths]}
    return scenario("thesis-open").for_evaluation().with_settings(maps)


def test_each_file_is_a_map_of_its_own_name(files):
    paths = [files / "one" / "room.txt", files / "other" / "room.txt", files / "larger.txt"]
    maps = task(*paths).map
    assert isinstance(maps, MapReader)
    assert (maps.count, maps.generated) == (3, False)
    plans = [maps.floorplan(index, seed=index) for index in range(3)]
    assert [plan.name for plan in plans] == ["one/room", "other/room", "larger"]
    assert [plan.shape for plan in plans] == [(4, 5), (4, 5), (6, 5)]
    assert all(plan.main_part.sum() == 3 * (plan.shape[0] - 2) for plan in plans)


def test_it_is_part_of_the_scenario_by_its_cells(files):
    found = task(files / "one" / "room.txt")
    assert (
        found == Scenario.model_validate(found.model_dump()) == Scenario.model_validate(found.model_dump(mode="json"))
    )
    assert found.fingerprint == task(files / "other" / "room.txt").fingerprint
    assert found.fingerprint != task(files / "larger.txt").fingerprint


def test_no_uav_is_told_the_files(files):
    world = World(task(files / "one" / "room.txt"))
    world.reset([1])
    maps = world.briefing(0, 0).scenario.map
    assert maps.paths == ("(not told)",)
    assert maps.free == "0"
    assert world.briefing(0, 0, privileged=True).scenario.map.paths == (str(files / "one" / "room.txt"),)


def test_maps_in_memory_need_no_files(files):
    maps = task(files / "larger.txt").map
    held = maps.holding({0: maps.floorplan(0, 0)})
    (files / "larger.txt").unlink()
    assert held.floorplan(0, 0).shape == (6, 5)
    assert not held.without_files()._held


@pytest.mark.parametrize(
    ("text", "message"),
    [("111\n11\n", "ValueError"), ("11\n11\n", "expected some free cells, got none"), (None, "Errno 2")],
)
def test_what_cannot_be_read_is_an_error_that_names_the_file(text, message, tmp_path):
    if text is not None:
        (tmp_path / "bad.txt").write_text(text)
    with pytest.raises(InputError, match=r"bad.txt: expected a map that .*:Tables reads, got .*") as refused:
        task(tmp_path / "bad.txt").map.floorplan(0, 0)
    assert message in str(refused.value)
