"""The audit of a split: what is found by which digest, near copies, and the command."""

import csv
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from indoor_explorers.env import scenario
from indoor_explorers.env.errors import InputError
from indoor_explorers.env.maps.files import write_picture
from indoor_explorers.env.simulation.spawns import draw_floorplan
from indoor_explorers.evaluation.cli import main
from indoor_explorers.evaluation.studies.maps.audit import AuditedMap, Kind, audited, map_files


@pytest.fixture(scope="module")
def folders(tmp_path_factory) -> tuple[Path, Path]:
    """Five generated floors to train on; to test on, four of them changed in some way, and one that is new."""
    train, test = (tmp_path_factory.mktemp(name) for name in ("train", "test"))
    plans = [draw_floorplan(scenario("small-floors"), seed, 0) for seed in range(6)]
    for number, plan in enumerate(plans[:5]):
        write_picture(plan, train / f"{number}.png")
    pictures = [np.array(Image.open(path)) for path in sorted(train.iterdir())]
    walls = pictures[3].copy()
    free = np.argwhere(walls == 255)
    walls[tuple(free[:: len(free) // 20].T)] = 0  # twenty pillars
    changed = {
        "same": pictures[0],
        "turned": np.rot90(pictures[1]),
        "rescaled": np.pad(pictures[2].repeat(2, axis=0).repeat(2, axis=1), 5)[:, ::-1],
        "pillars": np.flipud(walls),
    }
    for name, picture in changed.items():
        Image.fromarray(np.ascontiguousarray(picture)).save(test / f"{name}.png")
    write_picture(plans[5], test / "new.png")
    return train, test


def test_each_test_map_is_found_as_what_it_is(folders):
    train, test = ([AuditedMap.read(path) for path in map_files(folder)] for folder in folders)
    audit = audited(train, test, 0.9, None)
    assert {match.test.stem: (match.train.stem, match.kind) for match in audit.matches} == {
        "same": ("0", Kind.SAME),
        "turned": ("1", Kind.TURNED),
        "rescaled": ("2", Kind.RESCALED),
        "pillars": ("3", Kind.NEAR),
    }
    assert audit.layouts == (5, 5)
    assert audit.counts == dict.fromkeys(Kind, 1)
    (near,) = (match for match in audit.matches if match.kind is Kind.NEAR)
    assert 0.9 < near.overlap < 1.0
    assert len(audited(train, test, near.overlap + 0.001, None).matches) == 3


def test_the_command_prints_counts_and_writes_matches(folders, tmp_path, capsys):
    table = tmp_path / "matches.csv"
    assert main(["maps", "audit", *map(str, folders), "--out", str(table)]) == 0
    printed = capsys.readouterr().out
    assert "to train on: 5 maps, 5 different layouts" in printed
    assert "4 (1 same cells, 1 turned or mirrored, 1 cropped or rescaled, 1 near copy)" in printed
    with table.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(Path(row["test"]).stem, row["kind"]) for row in rows] == [
        ("pillars", "near copy"),
        ("rescaled", "cropped or rescaled"),
        ("same", "same cells"),
        ("turned", "turned or mirrored"),
    ]


def test_without_a_file_some_matches_are_listed(folders, capsys):
    assert main(["maps", "audit", str(folders[0]), str(folders[0] / "1.png"), "--near", "0.5"]) == 0
    assert f"{folders[0] / '1.png'} in {folders[0] / '1.png'}: same cells" in capsys.readouterr().out


def test_a_ros_map_is_read_once_and_folders_without_maps_are_refused(tmp_path):
    for name in ("a.yaml", "a.png", "b.png", "notes.txt"):
        (tmp_path / name).touch()
    assert [path.name for path in map_files(tmp_path)] == ["a.yaml", "b.png"]
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="expected a map file or a folder of them"):
        map_files(tmp_path / "empty")


def test_a_file_that_is_no_map_is_named(tmp_path, folders, capsys):
    (tmp_path / "broken.png").write_bytes(b"no picture")
    assert main(["maps", "audit", str(folders[0]), str(tmp_path)]) == 2
    assert "broken.png" in capsys.readouterr().err
