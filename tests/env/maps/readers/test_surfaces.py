"""Meshes and point clouds: known boxes, clouds in both layouts of PCD, and one line for what is wrong."""

import builtins

import numpy as np
import pytest

from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.maps.files import read_map
from tests.env.maps.readers.flights import flown
from tests.env.maps.test_bad_files import refusal

HEAD = "VERSION 0.7\nFIELDS x y z _ rgb\nSIZE 4 4 8 1 4\nTYPE F F F U F\nCOUNT 1 1 1 4 1\nWIDTH {n}\nHEIGHT 1\n"


@pytest.fixture
def trimesh():
    return pytest.importorskip("trimesh", reason="the extra meshes")


def free_of(plan):
    return np.array(plan.levels.volume(plan.truth)) == FREE


def shell(size=(12, 8, 6), apart=0.125):
    """The (n, 3) points of the surface of a box of so many cells of 0.25 m."""
    axes = [np.arange(side * 2 + 1) * apart for side in size]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    on = (points == 0) | (points == np.array(size) * 0.25)
    return points[on.any(axis=1)]


def pcd(points, kind="ascii", fields=HEAD):
    head = (fields + "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {n}\nDATA {kind}\n").format(n=len(points), kind=kind)
    if kind == "ascii":
        return head.encode() + b"\n".join(f"{x} {y} {z} 0 0 0 0 1".encode() for x, y, z in points)
    rows = np.zeros(len(points), [("x", "<f4"), ("y", "<f4"), ("z", "<f8"), ("_", "u1", 4), ("rgb", "<f4")])
    rows["x"], rows["y"], rows["z"] = points.T
    return head.encode() + rows.tobytes()


@pytest.mark.parametrize("kind", ["stl", "ply", "obj"])
def test_the_inside_of_a_box_is_free_and_all_around_solid(trimesh, tmp_path, kind):
    trimesh.creation.box((4, 3, 2)).export(tmp_path / f"box.{kind}")
    plan = read_map(tmp_path / f"box.{kind}", 0.5)
    assert (plan.level_count, plan.resolution, plan.kept) == (5, 0.5, 1.0)
    np.testing.assert_array_equal(free_of(plan), np.pad(np.ones((3, 5, 7), np.bool_), 1))


def test_no_move_passes_a_slanted_wall(trimesh, tmp_path):
    turned = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3])
    room = trimesh.creation.box((6, 5, 4), transform=turned)
    room.export(tmp_path / "room.stl")
    volume = free_of(read_map(tmp_path / "room.stl", 0.2)).sum() * 0.2**3
    assert 0.75 * 120 < volume < 120  # all outside is solid


def test_where_little_is_enclosed_all_between_is_free(trimesh, tmp_path):
    room = trimesh.creation.box((4, 3, 2))
    room.update_faces(room.triangles_center[:, 2] < 0.9)  # no ceiling
    room.export(tmp_path / "room.stl")
    free = free_of(read_map(tmp_path / "room.stl", 0.5))
    np.testing.assert_array_equal(free, np.pad(np.ones((4, 5, 7), np.bool_), 1))  # up to the top of the walls


def test_levels_rise_with_z_and_rows_run_against_y(trimesh, tmp_path):
    parts = [trimesh.creation.box((4, 4, 2)), trimesh.creation.box((1.2, 1.2, 0.7))]
    parts[1].apply_translation((-1.4, -1.4, -0.7))  # in the lower corner of small x and y
    trimesh.util.concatenate(parts).export(tmp_path / "room.ply")
    free = free_of(read_map(tmp_path / "room.ply", 0.25))
    low, high = free[1], free[-2]
    assert high[1:-1, 1:-1].all()
    assert not low[-3:-1, 1:3].any()
    assert low[1:3, -3:-1].all()


@pytest.mark.parametrize("kind", ["ascii", "binary"])
def test_a_cloud_is_read(tmp_path, kind):
    (tmp_path / "room.pcd").write_bytes(pcd(shell(), kind))
    plan = read_map(tmp_path / "room.pcd")
    np.testing.assert_array_equal(free_of(plan), np.pad(np.ones((5, 7, 11), np.bool_), 1))
    assert plan.resolution == 0.25


def test_a_cloud_in_ply_is_read_and_flown(trimesh, tmp_path):
    trimesh.PointCloud(shell()).export(tmp_path / "room.ply")
    assert free_of(read_map(tmp_path / "room.ply")).sum() == 5 * 7 * 11
    assert flown(tmp_path / "room.ply") == 1.0


def test_the_extra_is_named_where_it_is_missing(tmp_path, monkeypatch):
    plain = builtins.__import__

    def without(name, *rest, **more):
        if name.startswith("trimesh"):
            raise ModuleNotFoundError(f"No module named {name!r}")
        return plain(name, *rest, **more)

    (tmp_path / "box.stl").write_bytes(b"solid\n")
    monkeypatch.setattr(builtins, "__import__", without)
    assert "pip install 'indoor-explorers[meshes]'" in refusal(tmp_path / "box.stl")


@pytest.mark.parametrize("name", ["a.stl", "a.ply", "a.obj"])
@pytest.mark.parametrize("data", [b"", b"hello", b"\0" * 90, b"\0" * 80 + b"\xff" * 60, b"ply\nformat ascii 1.0\n"])
def test_files_that_are_no_mesh_are_refused_in_one_line(trimesh, tmp_path, name, data):
    (tmp_path / name).write_bytes(data)
    assert "expected a mesh or points" in refusal(tmp_path / name)


def test_sizes_that_cannot_be_are_refused(trimesh, tmp_path):
    trimesh.creation.box((4000, 3000, 2)).export(tmp_path / "field.stl")
    assert "expected at most 4,194,304 cells" in refusal(tmp_path / "field.stl")
    tiny = trimesh.Trimesh([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [[0, 1, 2]])
    tiny.export(tmp_path / "tiny.stl")
    assert "expected some free cells, got none" in refusal(tmp_path / "tiny.stl")


# fmt: off
@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "expected FIELDS x y z and DATA, got others"),
        (pcd(shell()).replace(b"FIELDS x y z", b"FIELDS a b c"), "expected FIELDS x y z and DATA"),
        (pcd(shell(), "binary_compressed"), "DATA: expected ascii or binary, got 'binary_compressed'"),
        (pcd(shell(), "binary")[:-40], "expected a point cloud in PCD 0.7"),
        (pcd(shell())[:-5], "expected a point cloud in PCD 0.7"),
        (pcd(shell() + np.inf), "expected a mesh or points, got none"),
        (pcd(shell() * 1e9), "expected points within 10,000 km of the origin"),
        (pcd(shell()[:0]), "expected a mesh or points, got none"),
    ],
)
def test_clouds_that_cannot_be_read_are_refused_in_one_line(tmp_path, data, message):
    (tmp_path / "bad.pcd").write_bytes(data)
    assert message in refusal(tmp_path / "bad.pcd")
# fmt: on
