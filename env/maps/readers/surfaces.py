"""Meshes and point clouds in metres, z upwards: ``.stl``, ``.ply`` and ``.obj`` through trimesh, and ``.pcd``.

Format of ``.pcd``: https://pointclouds.org/documentation/tutorials/pcd_file_format.html, version 0.7.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.maps.readers.opening import decoding, read_bytes
from indoor_explorers.env.maps.reduction import check_cells
from indoor_explorers.env.search.connected_parts import connected_parts

#: Metres a cell where none are asked for: a door of 0.9 m stays open between walls that are drawn into whole cells.
RESOLUTION = 0.25
#: The most bytes of a file, and the most points on the surfaces of a mesh.
MAX_BYTES, MAX_POINTS = 200_000_000, 30_000_000
#: The share of the box around all surfaces from which on a space that they enclose is the inside of a building.
INSIDE = 0.1

Points = NDArray[np.float64]
_KINDS = {"I": "i", "U": "u", "F": "f"}


def read_surfaces(path: Path, resolution: float | None = None) -> tuple[Belief, float]:
    """Read a mesh or a point cloud; return its (L, H, W) uint8 cells, 1 free or 2 occupied, and metres a cell.

    Cells that a surface or a point is in are occupied, and those of the border. What surfaces enclose is free, and all
    beyond occupied; but where they enclose less than a tenth of the box around them, as in a scan without a ceiling,
    all between is free. Levels are those of z, lowest first, rows run against y and columns along x.

    Raises :class:`InputError` with one line that says what is wrong with the file, or that trimesh is not installed.
    """
    metres = RESOLUTION if resolution is None else resolution
    if path.suffix.lower() == ".pcd":
        return _cells(path, _parse_pcd(path), metres), metres
    mesh, points = _parse_mesh(path)
    _check_size(path, np.concatenate([mesh.reshape(-1, 3), points]), metres)
    if len(mesh):
        points = np.concatenate([_sampled(path, mesh, metres / 2), points])
    return _cells(path, points, metres), metres


def _parse_mesh(path: Path) -> tuple[Points, Points]:
    """Return the (n, 3, 3) corners of a file's triangles, and its (m, 3) points that belong to none."""
    try:
        import trimesh
    except ImportError as error:
        raise InputError(
            f"{path}: expected trimesh for {path.suffix} files, got none; pip install 'indoor-explorers[meshes]'"
        ) from error
    read_bytes(path, MAX_BYTES, "a mesh")
    with decoding(path, f"a mesh or points in {path.suffix[1:].upper()}"):
        parts: list[Any] = trimesh.load_scene(path).dump()
        meshes = [part.triangles for part in parts if isinstance(part, trimesh.Trimesh)]
        clouds = [part.vertices for part in parts if isinstance(part, trimesh.PointCloud)]
        found = np.concatenate([np.zeros((0, 3, 3)), *meshes]), np.concatenate([np.zeros((0, 3)), *clouds])
    return found


def _sampled(path: Path, mesh: Points, apart: float) -> Points:
    """Return points of triangles (n, 3, 3), so close that no move between cells twice as large passes between them."""
    from trimesh.remesh import subdivide_to_size

    sides = np.linalg.norm(mesh - mesh[:, [1, 2, 0]], axis=-1).max(axis=-1)
    wanted = float(((sides / apart + 1) ** 2).sum())
    if wanted > MAX_POINTS:
        raise InputError(
            f"{path}: expected surfaces of at most {MAX_POINTS:,} points, got some {wanted:,.0f}; scale it"
        )
    corners = mesh.reshape(-1, 3)
    points, _ = subdivide_to_size(corners, np.arange(len(corners)).reshape(-1, 3), apart, max_iter=32)
    return np.asarray(points, np.float64)


def _parse_pcd(path: Path) -> Points:
    """Return the (n, 3) points of a ``.pcd`` file."""
    data = read_bytes(path, MAX_BYTES, "a point cloud")
    with decoding(path, "a point cloud in PCD 0.7"):
        head, mark, rest = data.partition(b"\nDATA ")
        kind, _, body = rest.partition(b"\n")
        lines = [line.split() for line in head.decode("ascii", "replace").splitlines()]
        facts = {line[0]: line[1:] for line in lines if len(line) > 1}
        if not mark or not {"x", "y", "z"} <= {*facts.get("FIELDS", ())}:
            raise InputError(f"{path}: expected FIELDS x y z and DATA, got others; is it a point cloud?")
        counts = [int(count) for count in facts.get("COUNT", ["1"] * len(facts["FIELDS"]))]
        if (stored := kind.strip().decode("ascii", "replace")) == "ascii":
            first = {name: sum(counts[:place]) for place, name in enumerate(facts["FIELDS"])}
            rows = np.array(body.split(), np.float64).reshape(-1, sum(counts))
            return rows[:, [first[axis] for axis in "xyz"]]
        if stored != "binary":
            raise InputError(
                f"{path}: DATA: expected ascii or binary, got {stored[:30]!r}; pcl_convert_pcd_ascii_binary converts it"
            )
        columns = zip(facts["FIELDS"], facts["TYPE"], facts["SIZE"], counts, strict=True)
        # a place in front of each name, since fillers are all named _
        layout = [(f"{at} {name}", f"<{_KINDS[k]}{size}", (n,)) for at, (name, k, size, n) in enumerate(columns)]
        records = np.frombuffer(body, np.dtype(layout), int(facts["POINTS"][0]))
        places = [facts["FIELDS"].index(axis) for axis in "xyz"]
        return np.concatenate([records[layout[at][0]].astype(np.float64) for at in places], axis=1)


def _check_size(path: Path, points: Points, metres: float) -> None:
    """Raise :class:`InputError` unless there are points and their box is not too large."""
    if not len(points):
        raise InputError(f"{path}: expected a mesh or points, got none; save it again")
    if not np.abs(points).max() <= 1e7:
        raise InputError(f"{path}: expected points within 10,000 km of the origin, got others; correct it")
    wide, tall, high = (int(side / metres) + 3 for side in np.ptp(points, axis=0))
    check_cells(str(path), high * (tall + 1), wide)


def _cells(path: Path, points: Points, metres: float) -> Belief:
    """Return the (L, H, W) cells of (n, 3) points that surfaces consist of."""
    points = points[np.isfinite(points).all(axis=1)]
    _check_size(path, points, metres)
    places = np.floor((points - points.min(axis=0)) / metres + 1e-6).astype(np.int64) + 1
    free = np.ones((places.max(axis=0) + 2)[::-1], np.bool_)
    free[places[:, 2], places[:, 1], places[:, 0]] = False
    parts, sizes = connected_parts(free)
    inside = sizes.copy()
    inside[[0, parts[0, 0, 0]]] = 0
    if inside.max() >= INSIDE * free[1:-1, 1:-1, 1:-1].size:
        free &= parts != parts[0, 0, 0]
    free[[0, -1]] = free[:, [0, -1]] = free[:, :, [0, -1]] = False
    return np.where(free[:, ::-1], np.uint8(FREE), np.uint8(OCCUPIED))
