"""Pictures of maps of several levels."""

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, World, make_policy
from indoor_explorers.env.grid.cells import UNKNOWN
from indoor_explorers.env.grid.levels import Levels
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.policies.explanation import Explanation, cell_text, sentence
from indoor_explorers.env.rendering import Trails, paint, scene_of
from indoor_explorers.env.rendering.explained import HEIGHT
from indoor_explorers.env.rendering.layout import GAP, MARGIN, Box, cell_size, layout_of
from indoor_explorers.env.rendering.painter import nearest_links
from indoor_explorers.env.rendering.palette import HIDDEN, INK, KNOWN, PAGE, uav_colours
from indoor_explorers.env.rendering.scene import Told
from indoor_explorers.env.rendering.side_by_side import SIDE, TITLE, SideBySide, paint_side_by_side
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from tests.env.rendering.scenes import copied, cut, pixel
from tests.env.rendering.test_painter import bare

TALL = PRESETS["small-storeys"].for_evaluation()


@pytest.fixture(scope="module")
def one():
    """A scene after 40 steps."""
    world, policy = World(TALL), make_policy("frontier-nearest")
    world.begin(0, 0)
    trails = Trails(world.state.truth.shape[1:])
    trails.restart(world.state.cell[0])
    for _ in rollout(world, ask_pilots(policy, make_pilots(policy, world), world)):
        trails.add(world.state.cell[0])
        if world.state.step[0] == 40:
            break
    return copied(scene_of(world, 0, trails))


def tower(cells, **settings):
    """A scene of UAVs in an open room of four levels of 9 by 9 cells, with the paths (K, N, 3) of the UAVs."""
    settings = {"map.storeys": 1, "map.storey_height": 4, "team": cells.shape[1]} | settings
    world = World(TALL.with_settings({"map.height": 9, "map.width": 9, "map.room_size": [3, 4]} | settings))
    world.begin(0, 1, floorplan=Floorplan.from_free(np.ones((4, 9, 9), bool), "tower"), spawns=cells[-1].tolist())
    levels = world.floorplan(0).levels
    paths = np.apply_along_axis(levels.cell, 2, cells)
    return copied(scene_of(world, 0), trails=paths, in_view=np.zeros_like(world.state.belief[0], bool))


def main(one):
    """The pixels of the team's map."""
    return cut(paint(one), layout_of(one.grid.shape, one.team).main)


def test_every_level_shows_what_the_team_knows_and_nothing_lies_between_them(one):
    picture, grid = main(bare(one)), one.grid
    cells = np.argwhere(~grid.levels.between)
    for cell, place in zip(map(tuple, cells), grid.places(cells), strict=True):
        table = HIDDEN if one.union[cell] == UNKNOWN else KNOWN
        assert np.array_equal(pixel(picture, grid.shape, place), table[one.truth[cell]]), cell
    blank = np.argwhere(grid.laid_out(np.ones(one.shape, bool), False) == 0)
    right = blank[blank[:, 1] >= grid.corner(1)[1] - grid.gap + 1]
    assert {tuple(pixel(picture, grid.shape, place)) for place in right[right[:, 0] > 60]} == {PAGE}


def test_uavs_are_on_their_levels(one):
    picture, colours = main(one), uav_colours(one.team).astype(int)
    for agent, place in enumerate(one.grid.places(one.cells)):
        disc = pixel(picture, one.grid.shape, place, towards=(0.9, 0.0))
        assert np.abs(disc - colours[agent]).max() < 40


def test_the_first_view_is_the_first_scan_of_all_levels():
    world = World(TALL)
    world.begin(0, 2)
    between, scene = Levels.of(world.state.truth.shape[1:], 7).between, scene_of(world, 0)
    for agent in range(TALL.team):
        known = world.state.belief[0, agent] != UNKNOWN
        if not world.state.linked[0, agent].any():
            assert (scene.in_view[agent] == (known & ~between)).all()
        assert (scene.in_view[agent] <= known).all()
        assert len({int(row) // 25 for row in np.argwhere(scene.in_view[agent])[:, 0]}) > 1


def test_a_trail_ends_where_its_uav_leaves_the_level():
    path = [(0, 2, col) for col in range(2, 7)] + [(1, 2, 6), (2, 2, 6)] + [(2, 2, col) for col in range(5, 1, -1)]
    one = tower(np.array(path)[:, None])
    plain = tower(np.array(path[-1:])[:, None])
    changed = np.abs(main(one).astype(int) - main(plain)).max(axis=2) > 8
    grid, size = one.grid, main(one).shape[0] / one.grid.shape[0]
    rows, cols = np.nonzero(changed)
    inside = grid.laid_out(np.ones(one.shape, bool), False)[(rows / size).astype(int), (cols / size).astype(int)]
    assert inside.all()
    drawn = {
        level
        for level in range(4)
        for row, col in [grid.corner(level)]
        if changed[int(row * size) : int((row + 9) * size), int(col * size) : int((col + 9) * size)].any()
    }
    assert drawn == {0, 1, 2}


def test_a_link_between_levels_is_dashed_and_one_on_a_level_is_not():
    shares = []
    for other in ((0, 4, 8), (1, 4, 1)):
        one = tower(np.array([[(0, 4, 0), other]]), **{"radio.model": "unlimited", "lidar.range": 1.0})
        one = copied(one, radio=("none", 0.0), lidar_range=0.0)
        assert one.linked[0, 1]
        picture, size = main(one), main(one).shape[1] / one.grid.shape[1]
        ends = (one.grid.places(one.cells) + 0.5) * size
        along = np.linspace(0.2, 0.8, 400)[:, None] * (ends[1] - ends[0]) + ends[0]
        line = picture[along[:, 0].astype(int), along[:, 1].astype(int)].astype(int)
        shares.append(float((np.abs(line - INK).max(axis=1) < 70).mean()))
    assert shares[0] > 0.95
    assert 0.25 < shares[1] < 0.75


def test_links_of_large_teams_are_those_near_in_three_dimensions():
    cells = np.array([[(0, 4, 4), (3, 4, 4), (0, 4, 8)]])
    one = copied(tower(cells), linked=~np.eye(3, dtype=bool))
    assert nearest_links(one).tolist() == [[False, True, True], [True, False, False], [True, False, False]]


def test_explanations_and_words_name_levels(one):
    levels = one.grid.levels
    assert cell_text((3 * 25 + 4, 5), levels) == "(3, 4, 5)"
    assert cell_text((79, 5)) == cell_text((79, 5), Levels(1, 90, 9)) == "(79, 5)"
    path = (levels.cell((3, 4, 5)), levels.cell((4, 4, 5)), levels.cell((4, 4, 6)))
    told = Explanation(step=7, goal=path[-1], path=path)
    assert sentence(told, levels) == "flies to (4, 4, 6), 2 steps away, chosen at step 7"
    plain = paint(one)
    with_way = paint(copied(one, told=Told(0, told)))
    assert with_way.shape == (plain.shape[0] + HEIGHT, *plain.shape[1:])
    changed = np.argwhere((with_way[: len(plain)] != plain).any(axis=2))
    assert len(changed)
    grid, main_box = one.grid, layout_of(one.grid.shape, one.team).main
    size = main_box.width / grid.shape[1]
    rows = (changed - (main_box.top, main_box.left)) / size
    spots = (grid.places(np.array(path)) + 0.5)[None]
    assert np.abs(rows[:, None] - spots).max(axis=2).min(axis=1).max() < 2.5


def test_several_flights_show_levels_too(one):
    plain, grid = bare(one), one.grid
    cell = cell_size(SIDE / max(grid.shape))
    height, width = (round(side * cell) for side in grid.shape)
    picture = paint_side_by_side([SideBySide(name, plain, [0.1, 0.4]) for name in "ab"], 40)
    for left in (MARGIN, MARGIN + width + GAP):
        box = cut(picture, Box(MARGIN + TITLE, left, height, width))
        for cell in map(tuple, np.argwhere(~grid.levels.between)[::7]):
            table = HIDDEN if one.union[cell] == UNKNOWN else KNOWN
            assert np.array_equal(pixel(box, grid.shape, grid.places(np.array(cell))), table[one.truth[cell]]), cell
