"""Paint a scene: the team's map with all UAVs, and each UAV's own map beside it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.rendering import overlays
from indoor_explorers.env.rendering.explained import mark, with_words
from indoor_explorers.env.rendering.layout import CAPTION, FOOTER, MARGIN, Box, FrameLayout, layout_of
from indoor_explorers.env.rendering.level_grid import LevelGrid
from indoor_explorers.env.rendering.overlays import OVERHANG, Chart
from indoor_explorers.env.rendering.palette import (
    BAR,
    FAINT,
    FALSE_FREE,
    FALSE_OCCUPIED,
    HAIRLINE,
    HIDDEN,
    INK,
    KNOWN,
    ONLY_PRIOR,
    ONLY_TRUTH,
    TROUGH,
    paler,
    uav_colours,
)
from indoor_explorers.env.rendering.primitives import Canvas, disc, fitting, resample, stroke, text_width, write
from indoor_explorers.env.rendering.scene import Scene, with_base
from indoor_explorers.env.simulation.state import End

#: Opacity of the UAVs' colours on the cells in view.
TINT = 0.25
#: Largest teams whose lidar and radio reach are outlined, whose mates are numbered on own maps, and whose ends are
#: written beside the UAVs.
OUTLINED, NUMBERED, LABELLED = 6, 8, 16
#: Least pixels of a cell for hairlines between cells.
RULED = 12
#: How a UAV's episode ended, in words.
ENDS = {
    End.GOAL: "goal",
    End.COLLISION: "collision",
    End.OUT_OF_BOUNDS: "out of bounds",
    End.STUCK: "stuck",
    End.BUDGET: "budget",
    End.STOPPED: "stopped",
}


def paint(scene: Scene) -> NDArray[np.uint8]:
    """Return the picture, (h, w, 3) uint8.

    Its size depends on the size of the map and of the team, and on whether a UAV is explained.
    """
    layout = layout_of(scene.grid.shape, scene.team)
    canvas = np.full((layout.height, layout.width, 3), 255, np.uint8)
    colours = _colours(scene)
    _caption(canvas, layout, scene)
    _team_map(canvas, layout.main, scene, colours)
    for agent, box in enumerate(layout.panels):
        _title(canvas, box, scene, agent, colours[agent])
        _own_map(canvas, box, scene, agent, colours[agent])
    if layout.missing:
        place = layout.main.left, layout.height - MARGIN - FOOTER / 2 + 4
        shown = f"own maps of UAVs 0 to {len(layout.panels) - 1}, +{layout.missing} more"
        write(canvas, place, shown, 13, FAINT, anchor=0.0)
    if scene.told is None:
        return canvas
    return with_words(canvas, scene.told, uav_colours(scene.team)[scene.told.agent], scene.grid.levels)


def paint_team_map(canvas: Canvas, box: Box, scene: Scene) -> None:
    """Paint the team's map of a scene into a box: the true map, dimmed where unknown, UAVs, trails and links."""
    _team_map(canvas, box, scene, _colours(scene))


def ended_early(scene: Scene) -> Mask:
    """Return (N,) the UAVs to mark as ended: none when the team has flown together to its goal or budget."""
    together = np.isin(scene.ends, (End.GOAL, End.BUDGET)).all()
    return np.asarray((scene.ends != End.FLYING) & ~together)


def nearest_links(scene: Scene) -> Mask:
    """Return (N, N) the links without a third UAV that is linked to both ends and nearer to either.

    They connect the same UAVs by fewer lines (Toussaint's relative neighbourhood graph, 1980).
    """
    cells = scene.grid.levels.voxels(scene.cells)
    away = ((cells[:, None] - cells) ** 2).sum(axis=2)
    away[~scene.linked] = np.iinfo(away.dtype).max
    kept = scene.linked.copy()
    for third in away:  # from one UAV to all
        kept &= away <= np.maximum(third[:, None], third)
    return kept


def floored_percent(share: float) -> str:
    """Return a share in percent, rounded down, so that 100.0% is all of it."""
    return f"{np.floor(1000 * share + 1e-9) / 10:.1f}%"


def _colours(scene: Scene) -> NDArray[np.uint8]:
    """Return (N, 3) the colours of the UAVs, paler where they have ended."""
    full = uav_colours(scene.team)
    return np.where(ended_early(scene)[:, None], paler(full), full)


def _caption(canvas: Canvas, layout: FrameLayout, scene: Scene) -> None:
    """Write title, step and coverage above a bar of the coverage."""
    left, right = MARGIN, layout.width - MARGIN
    ends = {End(int(end)) for end in scene.ends}
    over = "" if End.FLYING in ends else f"ended: {', '.join(ENDS[end] for end in sorted(ends))}  \u00b7  "
    facts = f"{over}step {scene.step:,} / {scene.budget:,}  \u00b7  coverage {floored_percent(scene.coverage)}"
    if scene.base is not None:
        facts += f", at the base {floored_percent(scene.base_coverage)}"
    line = MARGIN + 10
    write(canvas, (right, line), facts, 15, INK, anchor=1.0)
    room = right - left - text_width(facts, 15) - 24
    write(canvas, (left, line), fitting(scene.title, 17, room), 17, INK, anchor=0.0)
    bar = MARGIN + CAPTION - 18.0
    stroke(canvas, [(left + 2, bar), (right - 2, bar)], TROUGH, 4)
    if scene.coverage > 0:
        stroke(canvas, [(left + 2, bar), (left + 2 + (right - left - 4) * min(scene.coverage, 1.0), bar)], BAR, 4)


def _team_map(canvas: Canvas, box: Box, scene: Scene, colours: NDArray[np.uint8]) -> None:
    """Paint the true map, dimmed where the team does not know it, UAVs, trails and links.

    Wrong cells of the team's map, and unknown walls that only the true or only the prior map has, have their own
    colours.
    """
    known = scene.union != UNKNOWN
    ground = np.take(np.concatenate((HIDDEN, KNOWN)), scene.truth + 3 * known, axis=0)
    ground[(scene.union == OCCUPIED) & (scene.truth == FREE)] = FALSE_OCCUPIED
    ground[(scene.union == FREE) & (scene.truth == OCCUPIED)] = FALSE_FREE
    if scene.prior is not None:
        ground[~known & (scene.truth == FREE) & (scene.prior == OCCUPIED)] = ONLY_PRIOR
        ground[~known & (scene.truth == OCCUPIED) & (scene.prior == FREE)] = ONLY_TRUTH
    _tint(ground, scene, uav_colours(scene.team))
    chart = _lay(canvas, box, ground, 7.0 if scene.team > LABELLED else 9.0, scene.grid)
    flying = scene.ends == End.FLYING
    if scene.team <= OUTLINED:
        for agent in np.flatnonzero(flying).tolist():
            overlays.lidar_reach(chart, scene.cells[agent], scene.lidar_range, colours[agent])
            if scene.team > 1:
                overlays.radio_reach(chart, scene.cells[agent], *scene.radio, colours[agent])
    for agent in range(scene.team):
        overlays.trail(chart, scene.trails[:, agent], colours[agent], _lane(scene, agent))
    overlays.links(chart, *_drawn_links(scene))
    if scene.base is not None:
        overlays.base(chart, np.array(scene.base))
    for agent in np.flatnonzero(ended_early(scene)).tolist() if scene.team <= LABELLED else ():
        end = End(int(scene.ends[agent]))
        overlays.label(chart, scene.cells, agent, f"{agent}: {ENDS[end]}" if end == End.STOPPED else ENDS[end])
    if scene.told is not None and scene.told.explanation is not None:
        mark(chart, scene.told.explanation, uav_colours(scene.team)[scene.told.agent])
    for agent in np.argsort(flying, kind="stable").tolist():  # flying UAVs last, on top
        overlays.uav(chart, scene.cells[agent], colours[agent], agent)
        if scene.ends[agent] == End.STOPPED:
            overlays.stopped(chart, scene.cells[agent])


def _drawn_links(scene: Scene) -> tuple[NDArray[np.int64], Mask]:
    """Return the cells (M, 2) of the UAVs, and of the home base, and the links (M, M) to draw between them."""
    linked = scene.linked if scene.team <= NUMBERED else nearest_links(scene)
    if scene.base is None or scene.base_linked is None:
        return scene.cells, linked
    return np.concatenate((scene.cells, [scene.base])), with_base(linked, scene.base_linked)


def _own_map(canvas: Canvas, box: Box, scene: Scene, agent: int, colour: NDArray[np.uint8]) -> None:
    """Paint the knowledge of one UAV: its own map over the prior one, its trail and the positions it has received."""
    few = scene.team <= NUMBERED
    ground = np.take(KNOWN, scene.beliefs[agent], axis=0)
    if scene.prior is not None:
        ground[(scene.beliefs[agent] == UNKNOWN) & (scene.prior == OCCUPIED)] = HIDDEN[OCCUPIED]
    chart = _lay(canvas, box, ground, 7.0 if few else 6.0, scene.grid)
    if scene.base is not None:
        overlays.base(chart, np.array(scene.base))
    overlays.trail(chart, scene.trails[:, agent], colour, _lane(scene, agent))
    ages = scene.heard_age[agent]
    for mate in np.argsort(-ages, kind="stable").tolist():  # the latest news last, on top
        if ages[mate] >= 0 and mate != agent:
            place, full = scene.heard_cell[agent, mate], uav_colours(scene.team)[mate]
            overlays.mate(chart, place, full, mate, int(ages[mate]), small=not few)
    overlays.uav(chart, scene.cells[agent], colour, agent)


def _title(canvas: Canvas, box: Box, scene: Scene, agent: int, colour: NDArray[np.uint8]) -> None:
    """Write a UAV's number, how it ended, and how many cells it knows above its map."""
    end = End(int(scene.ends[agent]))
    title = f"UAV {agent}"
    maps = (scene.grid.levels.volume(cells) for cells in (scene.beliefs[agent], scene.truth))
    known, most = (f"{np.count_nonzero(cells):,} cells" for cells in maps)
    line, room = box.top - 10.0, box.width - 14
    if ended_early(scene)[agent]:
        long, short = f"{title}: {ENDS[end]}", f"{agent}: {ENDS[end]}"
        title = long if text_width(long, 13) <= room else short
    disc(canvas, (box.left + 5.0, line), 4.5, colour)
    if text_width(max(title, f"UAV {scene.team - 1}", key=len), 13) + text_width(most, 13) + 12 <= room:
        write(canvas, (box.left + box.width, line), known, 13, FAINT, anchor=1.0)
    write(canvas, (box.left + 14, line), fitting(title, 13, room), 13, INK, anchor=0.0)


def _lane(scene: Scene, agent: int) -> float:
    return 0.07 * (agent % 5 - 2) if scene.team > 1 else 0.0


def _lay(canvas: Canvas, box: Box, ground: NDArray[np.uint8], least: float, grid: LevelGrid) -> Chart:
    """Put (H, W, 3) cells into a box with a hairline around each level.

    ``least`` is the least radius of a UAV's disc.
    """
    top, left, height, width = box
    inside = canvas[top : top + height, left : left + width]
    around = canvas[top - OVERHANG : top + height + OVERHANG, left - OVERHANG : left + width + OVERHANG]
    resample(grid.laid_out(ground, 255), inside)
    chart = Chart(inside, around, width / grid.shape[1], least, grid)
    for level in range(grid.levels.number):
        tile = chart.tile(level)
        _rule(inside[tile.top : tile.top + tile.height, tile.left : tile.left + tile.width], width // grid.shape[1])
        row, col = tile.top + OVERHANG - 1, tile.left + OVERHANG - 1
        around[[row, row + tile.height + 1], col : col + tile.width + 2] = HAIRLINE
        around[row : row + tile.height + 2, [col, col + tile.width + 1]] = HAIRLINE
        size = min(13.0, 0.8 * grid.gap * chart.cell)
        if size >= 7:
            write(around, (col, row - grid.gap * chart.cell / 2), f"level {level}", size, FAINT, anchor=0.0)
    return chart


def _rule(cells: Canvas, size: int) -> None:
    """Draw hairlines between cells of ``size`` pixels, where these are large."""
    if size >= RULED:
        for line in (cells[size::size], cells[:, size::size]):
            line[:] = line - line // 14


def _tint(ground: NDArray[np.uint8], scene: Scene, colours: NDArray[np.uint8]) -> None:
    """Blend the mean colour of the UAVs that see a cell into it."""
    mixed = np.zeros((scene.truth.size, 3), np.int32)
    seers = np.zeros(scene.truth.size, np.int32)
    for agent in range(scene.team):
        seen = np.flatnonzero(scene.in_view[agent])
        mixed[seen] += colours[agent]
        seers[seen] += 1
    lit = np.flatnonzero(seers)
    flat = ground.reshape(-1, 3)
    flat[lit] = ((1 - TINT) * flat[lit] + TINT * mixed[lit] / seers[lit, None]).astype(np.uint8)
