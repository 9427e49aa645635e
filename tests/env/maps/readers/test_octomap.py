"""Octrees of OctoMap: what is written is read, by this package and by OctoMap itself, and bad files are refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.maps.files import read_map
from indoor_explorers.env.maps.readers.octomap import read_octomap, write_octomap
from tests.env.maps.readers.flights import flown
from tests.env.maps.test_bad_files import refusal

HEAD = b"# Octomap OcTree binary file\nid OcTree\nsize 1\nres 0.5\ndata\n"


def noise(shape, seed=0, share=0.3):
    return np.where(np.random.default_rng(seed).random(shape) < share, OCCUPIED, FREE).astype(np.uint8)


@settings(max_examples=40, deadline=None)
@given(st.tuples(*[st.integers(1, 9)] * 3), st.integers(0, 99), st.sampled_from([0.0, 0.02, 0.5, 1.0]))
def test_what_is_written_is_read(tmp_path_factory, shape, seed, share):
    path, cells = tmp_path_factory.getbasetemp() / "noise.bt", noise(shape, seed, share)
    write_octomap(cells, 0.25, path)
    read, metres = read_octomap(path)
    np.testing.assert_array_equal(read, cells)
    assert metres == 0.25


def test_octomap_reads_what_is_written_and_writes_what_is_read(tmp_path):
    octomap = pytest.importorskip("pyoctomap", reason="OctoMap's own library")
    cells = noise((3, 6, 7))
    write_octomap(cells, 0.5, tmp_path / "ours.bt")
    tree = octomap.OcTree(1.0)
    assert tree.readBinary(str(tmp_path / "ours.bt"))
    assert tree.getResolution() == 0.5
    own = octomap.OcTree(0.5)
    for (level, row, col), cell in np.ndenumerate(cells):
        place = [(col + 0.5) / 2, (6 - row - 0.5) / 2, (level + 0.5) / 2]
        assert tree.isNodeOccupied(tree.search(place)) == (cell == OCCUPIED)
        own.updateNode(place, bool(cell == OCCUPIED))
    assert own.writeBinary(str(tmp_path / "theirs.bt"))
    np.testing.assert_array_equal(read_octomap(tmp_path / "theirs.bt")[0], cells)


def test_unknown_is_solid_and_cells_of_several_voxels_are_occupied_where_one_is(tmp_path):
    cells = np.full((2, 4, 6), FREE, np.uint8)
    cells[0, 0, 0], cells[:, :2, 4:] = OCCUPIED, UNKNOWN
    write_octomap(cells, 0.1, tmp_path / "room.bt")
    np.testing.assert_array_equal(read_octomap(tmp_path / "room.bt")[0], cells)
    coarse, metres = read_octomap(tmp_path / "room.bt", 0.2)
    np.testing.assert_array_equal(coarse, [[[OCCUPIED, FREE, UNKNOWN], [FREE, FREE, FREE]]])
    assert metres == pytest.approx(0.2)
    plan = read_map(tmp_path / "room.bt")
    assert (plan.level_count, plan.resolution) == (2, 0.1)
    np.testing.assert_array_equal(plan.levels.volume(plan.truth) == FREE, cells == FREE)


def test_a_uav_flies_in_an_octree(tmp_path):
    cells = np.pad(np.full((2, 6, 6), FREE, np.uint8), 1, constant_values=OCCUPIED)
    write_octomap(cells, 0.5, tmp_path / "room.bt")
    assert flown(tmp_path / "room.bt") == 1.0


# fmt: off
@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "expected '# Octomap OcTree binary file' and a line 'data', got another file"),
        (b"# Octomap OcTree file\nid OcTree\n", "expected '# Octomap OcTree binary file'"),
        (HEAD.replace(b"id OcTree", b"id ROcTree"), "id: expected OcTree or ColorOcTree, got 'ROcTree'"),
        (HEAD.replace(b"0.5", b"nan") + b"\x00\x00", "res: expected metres a voxel, got 'nan'"),
        (HEAD.replace(b"res 0.5\n", b"") + b"\x00\x00", "res: expected metres a voxel, got 'none'"),
        (HEAD, "expected two bytes of data for each node, got 0"),
        (HEAD + b"\x00", "the file is truncated"),
        (HEAD + b"\x00\x00", "expected one octree of depth 16, got one that knows nothing"),
        (HEAD + b"\x03\x00", "got one that ends early"),
        (HEAD + b"\x01\x00\x00\x00", "got one that has data after its end"),
        (HEAD + b"\xff" * 100_000, "got one that ends early, or is too deep"),
        (HEAD + b"\x01\x00", "expected at most 4,194,304 cells"),
    ],
)
def test_files_that_are_no_octree_are_refused_in_one_line(tmp_path, data, message):
    path = tmp_path / "bad.bt"
    path.write_bytes(data)
    assert message in refusal(path)
# fmt: on


def test_a_resolution_between_voxels_is_refused(tmp_path):
    write_octomap(noise((2, 4, 4)), 0.1, tmp_path / "noise.bt")
    with pytest.raises(ValueError, match=r"expected a --resolution of a whole number of voxels of 0\.1 m, got 0\.25 m"):
        read_map(tmp_path / "noise.bt", 0.25)
