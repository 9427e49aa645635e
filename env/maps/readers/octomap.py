"""Occupancy octrees of OctoMap (Hornung et al., Autonomous Robots 34, 2013): binary ``.bt`` files, read and written.

Format: https://octomap.github.io, ``OcTree::writeBinaryNode``: lines of text up to ``data``, then the inner nodes in
depth-first order, two bytes each. Their bits 2k and 2k + 1 say what child k is: 0 unknown, 1 free, 2 occupied, 3 an
inner node; bits 0, 1 and 2 of k are its halves of x, y and z. Files may come from anywhere: OctoMap's own reader ends
the process on a tree that is too deep, so this one counts.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.compiled import inner, leaf
from indoor_explorers.env.maps.readers.opening import read_bytes
from indoor_explorers.env.maps.reduction import check_cells

#: Depth of a tree: 2 ** 16 voxels along each side, of which the file's origin is in the middle.
DEPTH = 16
#: The most bytes a file may have; the largest published ones have some ten million.
MAX_BYTES = 100_000_000
#: The first line of a file, and the kinds of trees that keep occupancies alone in it.
MAGIC, TREES = b"# Octomap OcTree binary file", ("OcTree", "ColorOcTree")
#: The code of an inner node; those of leaves are the values of cells.
INNER = 3


def read_octomap(path: Path, resolution: float | None = None) -> tuple[Belief, float]:
    """Read a ``.bt`` file; return the (L, H, W) uint8 cells around all known voxels, and metres a cell.

    Cells are 0 unknown, 1 free or 2 occupied; levels are those of z, lowest first, rows run against y and columns along
    x. With a ``resolution`` of some voxels a cell is occupied where one of them is, else free where one of them is.

    Raises :class:`InputError` with one line that says what is wrong with the file or the resolution.
    """
    words, metres = _parse(path)
    factor = _factor(path, metres, resolution)
    box, stack = np.array([2**DEPTH] * 3 + [0] * 3), np.zeros((8 * DEPTH, 4), np.int64)
    found = _walk(words, stack, box, np.zeros((0, 0, 0), np.uint8), 1)
    if found != len(words) or box[3] == 0:
        got = "ends early, or is too deep" if found < 0 else "has data after its end" if box[3] > 0 else "knows nothing"
        raise InputError(f"{path}: expected one octree of depth {DEPTH}, got one that {got}; save it again")
    size = [-(-int(side) // factor) for side in box[3:] - box[:3]]
    check_cells(str(path), size[2] * (size[1] + 1), size[0])
    cells = np.zeros(size[::-1], np.uint8)
    _walk(words, stack, box, cells, factor)
    return np.ascontiguousarray(cells[:, ::-1]), metres * factor


def _parse(path: Path) -> tuple[NDArray[np.uint16], float]:
    """Return the (n,) inner nodes of a file in their order, and metres a voxel."""
    head, mark, data = read_bytes(path, MAX_BYTES, "an OctoMap").partition(b"\ndata\n")
    if not (head.startswith(MAGIC) and mark):
        raise InputError(f"{path}: expected {MAGIC.decode()!r} and a line 'data', got another file; save it as .bt")
    lines = (line.split(None, 1) for line in head.decode("ascii", "replace").splitlines() if not line.startswith("#"))
    facts = {words[0]: words[1] for words in lines if len(words) == 2}
    if facts.get("id") not in TREES:
        raise InputError(f"{path}: id: expected {' or '.join(TREES)}, got {facts.get('id', 'none')[:40]!r}; convert it")
    try:
        metres = float(facts.get("res", ""))
    except ValueError:
        metres = math.nan
    if not 1e-6 <= metres <= 1e6:
        raise InputError(f"{path}: res: expected metres a voxel, got {facts.get('res', 'none')[:40]!r}; correct it")
    if len(data) % 2 or not data:
        raise InputError(f"{path}: expected two bytes of data for each node, got {len(data):,}; the file is truncated")
    return np.frombuffer(data, "<u2"), metres


def _factor(path: Path, metres: float, resolution: float | None) -> int:
    """Return voxels a cell along each side."""
    factor = 1.0 if resolution is None else resolution / metres
    if 1 <= round(factor) <= 2**DEPTH and abs(factor - round(factor)) < 1e-6 * factor:
        return round(factor)
    raise InputError(
        f"{path}: expected a --resolution of a whole number of voxels of {metres:g} m, got {resolution:g} m; change it"
    )


@inner()
def _enter(box: np.ndarray, cells: np.ndarray, factor: int, low: tuple[int, int, int], side: int, code: int) -> None:
    """Enter a leaf into the (L, W', W) ``cells``, or, where there are none, into the (6,) ``box`` of all leaves."""
    if cells.size == 0:
        for axis in range(3):
            box[axis], box[3 + axis] = min(box[axis], low[axis]), max(box[3 + axis], low[axis] + side)
        return
    x, y, z = low[0] - box[0], low[1] - box[1], low[2] - box[2]
    for level in range(z // factor, (z + side - 1) // factor + 1):
        for row in range(y // factor, (y + side - 1) // factor + 1):
            for col in range(x // factor, (x + side - 1) // factor + 1):
                cells[level, row, col] = max(cells[level, row, col], code)


@leaf()
def _walk(words: np.ndarray, stack: np.ndarray, box: np.ndarray, cells: np.ndarray, factor: int) -> int:
    """Walk through a tree and enter its leaves; return the number of its nodes, -1 where words lack or it is too deep.

    ``stack`` (8 DEPTH, 4) int64 is scratch memory.
    """
    stack[0, :3], stack[0, 3], held, read = 0, DEPTH, 1, 0
    while held > 0:
        held -= 1
        x, y, z, depth = stack[held, 0], stack[held, 1], stack[held, 2], stack[held, 3] - 1
        if read == len(words) or depth < 0:
            return -1
        word = int(words[read])
        read += 1
        for child in range(7, -1, -1):
            code, side = (word >> 2 * child) & 3, 1 << depth
            low = (x + (child & 1) * side, y + (child >> 1 & 1) * side, z + (child >> 2) * side)
            if code == INNER:
                stack[held, 0], stack[held, 1], stack[held, 2], stack[held, 3] = low[0], low[1], low[2], depth
                held += 1
            elif code > 0:
                _enter(box, cells, factor, low, side, code)
    return read


def write_octomap(cells: Belief, metres: float, path: Path) -> None:
    """Write (L, H, W) uint8 ``cells`` of so many ``metres``, none unknown, as :func:`read_octomap` reads them.

    The first level, last row and first column begin at the origin. Octants of equal cells are pruned, as OctoMap does.
    """
    if max(cells.shape) > 2 ** (DEPTH - 1):
        raise InputError(f"{path}: expected at most {2 ** (DEPTH - 1):,} cells along a side, got {max(cells.shape):,}")
    codes, keys, words, count = np.ascontiguousarray(cells[:, ::-1]), [], [], 0
    for depth in range(1, DEPTH + 1):
        octants = _octants(codes)
        alike = (octants == octants[..., :1]).all(axis=-1) & (octants[..., 0] != INNER)
        codes = np.where(alike, octants[..., 0], np.uint8(INNER))
        split = octants[codes == INNER]
        first = 7 if depth == DEPTH else 0  # the root's last child holds all voxels from the origin on
        words.append((split.astype(np.int64) << (2 * (first + np.arange(8)))).sum(axis=1) & 0xFFFF)
        keys.append(_morton(np.argwhere(codes == INNER) << depth) * (DEPTH + 1) + DEPTH - depth)
        count += len(split) + int(((split > 0) & (split < INNER)).sum())
    data = np.concatenate(words)[np.argsort(np.concatenate(keys))].astype("<u2").tobytes()
    path.write_bytes(f"{MAGIC.decode()}\nid OcTree\nsize {count}\nres {metres:.12g}\ndata\n".encode() + data)


def _octants(codes: Belief) -> Belief:
    """Return the eight children of each node of a level, (ceil L / 2, ceil H / 2, ceil W / 2, 8)."""
    even = np.pad(codes, [(0, side % 2) for side in codes.shape])
    level, row, col = (side // 2 for side in even.shape)
    return even.reshape(level, 2, row, 2, col, 2).transpose(0, 2, 4, 1, 3, 5).reshape(level, row, col, 8)


def _morton(places: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the place in depth-first order of (n, 3) voxels (z, y, x): their bits interleaved."""
    bits = (places[:, [2, 1, 0], None] >> np.arange(DEPTH)) & 1
    return np.asarray((bits << (3 * np.arange(DEPTH) + np.arange(3)[:, None])).sum(axis=(1, 2)))
