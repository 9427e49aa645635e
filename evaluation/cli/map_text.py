"""Maps for the terminal: a picture in characters and a line of facts."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator
from itertools import groupby
from pathlib import Path

import numpy as np

from indoor_explorers.env import InputError
from indoor_explorers.env.grid.arrays import Belief, Cell, Mask
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.kinds import Kind, PlanStatistics, has_scale
from indoor_explorers.env.maps.reduction import Source, reduced, settled
from indoor_explorers.env.maps.room_graph import (
    CORRIDOR,
    DOOR,
    ROOM,
    doors_across,
    loops,
    nodes_of,
    passage_of,
    room_graph,
)
from indoor_explorers.env.policies.explanation import cell_text
from indoor_explorers.env.rendering.level_grid import LevelGrid
from indoor_explorers.evaluation.drawing.formatting import counted

#: The mark of the start in a picture.
START = "S"

#: The share of the free area from which on a map loses no suspicious part, and a usual map's cells along a side.
LEAST_KEPT, USUAL_SIDE = 0.5, 100
#: Endings of pictures, which have no scale.
PICTURES = (".png", ".pgm", ".pnm", ".bmp")

#: The dot of a braille pattern (U+2800 on) for each of its 4 x 2 places.
_DOTS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])


def facts(floorplan: Floorplan) -> str:
    """Return one line about a map: size, resolution, free area, share connected before the cut, share kept, start."""
    free = int((floorplan.truth == FREE).sum())
    scale, area = "no scale", f"{free} free"
    if floorplan.resolution:
        scale = f"{floorplan.resolution:g} m a cell"
        unit = "m2" if floorplan.level_count == 1 else "m3"
        area += f" ({free * floorplan.resolution ** int(unit[1]):,.1f} {unit})"
    start = "" if floorplan.start is None else f"; start at {cell_text(floorplan.start, floorplan.levels)}"
    return (
        f"{floorplan.name}: {' x '.join(map(str, floorplan.levels.size))} cells, {scale}, {area}, "
        f"{min(floorplan.connected, floorplan.main_part.sum() / free):.1%} of the source's free area connected, "
        f"{floorplan.kept:.1%} kept{start}"
    )


def layout(floorplan: Floorplan) -> str:
    """Return a line about the rooms of a map, the doors between them, loops, and how many doors lie across it.

    Several levels have a line each, or those together that follow each other and are alike.
    """
    passage = passage_of(floorplan.resolution)
    if floorplan.level_count == 1:
        return _rooms(floorplan.main_part, passage)
    volume = floorplan.levels.volume(floorplan.main_part)
    lines = [_rooms(floor, passage) if floor.any() else "nothing free" for floor in volume]
    shares = [f"{floor.mean():.0%} free" for floor in volume]
    told = groupby(range(len(lines)), key=lambda level: (lines[level], shares[level]))
    return "\n".join(f"{_named([*levels])}: {share}; {line}" for (line, share), levels in told)


def _named(levels: list[int]) -> str:
    return f"level {levels[0]}" if len(levels) == 1 else f"levels {levels[0]} to {levels[-1]}"


def _rooms(floor: Mask, passage: int) -> str:
    graph = room_graph(np.pad(floor, 1), passage)
    doors = sum(graph.nodes[node]["width"] <= passage for node in nodes_of(graph, DOOR))
    parts = [counted(len(nodes_of(graph, kind)), kind) for kind in (ROOM, CORRIDOR)]
    line = ", ".join([*parts, counted(doors, DOOR), counted(loops(graph), "loop")])
    return f"{line}; at most {counted(doors_across(graph), 'passage')} from one to another"


def statistics(floorplan: Floorplan, found: PlanStatistics) -> str:
    """Return one line about a map: its kind, and the statistics that tell it."""
    unit = "m" if has_scale(floorplan) else "cells"
    levels = ", mean over levels" if floorplan.level_count > 1 else ""
    return (
        f"{found.kind}{levels}: clearance {found.clearance:.2f} {unit}, openness {found.openness:.2f}, "
        f"{found.view:.0%} of the floor in view, {found.rooms:.1f} effective rooms, {found.corridors:.0%} corridors, "
        f"{found.one_width:.0%} of one width, solidity {found.solidity:.2f}, walls {found.straight:.0%} straight"
    )


def kinds(maps: Iterable[tuple[str, Kind]]) -> Iterator[str]:
    """Yield a line for each source of some maps, given by source and kind: how many it has of each kind."""
    counts: dict[str, Counter[Kind]] = {}
    for source, kind in maps:
        counts.setdefault(source, Counter())[kind] += 1
    for source, found in counts.items():
        yield f"{source}: {', '.join(f'{count} {kind}' for kind, count in found.most_common())}"


def cautions(floorplan: Floorplan, path: Path | None = None, resolution: float | None = None) -> list[str]:
    """Return a line for each suspicious property of a map.

    Args:
        floorplan: the map.
        path: its file; None where it is from none.
        resolution: the metres per cell that were asked for.

    """
    lines = [*floorplan.notes]
    if floorplan.kept < LEAST_KEPT:
        lines.append(
            f"{floorplan.name}: only {floorplan.kept:.1%} of the free area is left, the largest connected part: is it "
            "a map, are its doors open, is --resolution fine enough?"
        )
    if path is not None and path.suffix.lower() in PICTURES:
        lines.append(f"{path.name}: a picture has no scale: a pixel is taken for 1 m")
        if resolution is None and (factor := math.ceil(max(floorplan.shape) / USUAL_SIDE)) > 1:
            lines[-1] += f"; --resolution {factor} makes {USUAL_SIDE} cells or fewer of each side"
    return lines


def picture(floorplan: Floorplan, width: int) -> str:
    """Return a map as text of at most ``width`` characters a line, walls drawn and the floor left blank.

    A map that is narrow enough is drawn in half blocks, one cell wide and two high; a wider one in braille dots, two
    cells wide and four high. One that is wider still is reduced first, so that doors stay open where they can. Several
    levels are drawn beside each other, each below its name.
    """
    levels, blocks = floorplan.levels, []
    if levels.number == 1:
        return _drawn(floorplan.truth, floorplan.name, floorplan.start, width)
    room = max(levels.width, len(f"level {levels.number}"))
    columns = min(LevelGrid.of(levels).columns, max(1, (width + 1) // (room + 1)))
    start = None if floorplan.start is None else levels.voxel(floorplan.start)
    for level, cells in enumerate(levels.volume(floorplan.truth)):
        here = None if start is None or start[0] != level else start[1:]
        drawn = _drawn(np.ascontiguousarray(cells), floorplan.name, here, width)
        blocks.append([f"level {level}", *drawn.split("\n")])
    rows = [zip(*blocks[first : first + columns], strict=True) for first in range(0, levels.number, columns)]
    return "\n".join(" ".join(part.ljust(room) for part in line).rstrip(" ") for row in rows for line in row)


def _drawn(cells: Belief, name: str, start: Cell | None, width: int) -> str:
    """Return the cells of a map, or of one level, as text."""
    free = cells == FREE
    if free.shape[1] <= width:
        return _text(_half_blocks(~free), start, (2, 1))
    scale = math.ceil(free.shape[1] / max(2 * width, 2))
    if scale > 1:
        free = _coarse(cells, name, scale)
        start = settled(start, free, scale)
    return _text(_braille(~free), start, (4, 2))


def _coarse(cells: Belief, name: str, scale: int) -> Mask:
    """Return the free cells of a map reduced ``scale`` times; if too few stay free, the half-free blocks."""
    source = Source(name=name, where=name, cells=cells, resolution=1.0)
    try:
        coarse = reduced(source, float(scale))
    except InputError:  # corridors narrower than half a character's dot
        coarse = None
    if coarse is not None and coarse.kept >= 0.5:
        return np.asarray(coarse.truth == FREE)
    rows, cols = (math.ceil(side / scale) for side in cells.shape)
    padded = np.zeros((rows * scale, cols * scale), np.bool_)
    padded[: cells.shape[0], : cells.shape[1]] = cells == FREE
    shares = padded.reshape(rows, scale, cols, scale).mean(axis=(1, 3))
    return np.asarray(shares >= min(0.5, float(np.median(shares))))


def _half_blocks(solid: Mask) -> list[list[str]]:
    """Return characters for (2, 1) cells each."""
    padded = np.pad(solid, [(0, solid.shape[0] % 2), (0, 0)])
    codes = 2 * padded[::2].astype(int) + padded[1::2]
    return [[" ▄▀█"[code] for code in line] for line in codes.tolist()]


def _braille(solid: Mask) -> list[list[str]]:
    """Return characters for (4, 2) cells each."""
    rows, cols = -(-solid.shape[0] // 4), -(-solid.shape[1] // 2)
    padded = np.zeros((4 * rows, 2 * cols), np.bool_)
    padded[: solid.shape[0], : solid.shape[1]] = solid
    codes = (padded.reshape(rows, 4, cols, 2) * _DOTS[None, :, None, :]).sum(axis=(1, 3))
    return [[chr(0x2800 + code) for code in line] for line in codes.tolist()]


def _text(lines: list[list[str]], start: Cell | None, cells: tuple[int, int]) -> str:
    """Join characters that stand for ``cells`` each to lines, with the start marked."""
    if start is not None:
        lines[start[0] // cells[0]][start[1] // cells[1]] = START
    return "\n".join("".join(line) for line in lines)
