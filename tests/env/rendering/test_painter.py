"""What a picture shows, pixel by pixel, and what it must not."""

import dataclasses

import numpy as np
import pytest
from scipy.sparse.csgraph import connected_components

from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.rendering import Trails, floored_percent, paint, scene_of
from indoor_explorers.env.rendering.layout import CAPTION, MARGIN, PANELS, layout_of
from indoor_explorers.env.rendering.painter import nearest_links
from indoor_explorers.env.rendering.palette import (
    HIDDEN,
    INK,
    KNOWN,
    ONLY_PRIOR,
    ONLY_TRUTH,
    PAGE,
    STOP,
    paler,
    uav_colours,
)
from indoor_explorers.env.rendering.scene import base_links
from indoor_explorers.env.sensing.lidar import scan
from indoor_explorers.env.simulation.state import End
from tests.env.rendering.scenes import copied, flown, main_map, panel, pixel, plan, random_plan, scene

OPEN = plan(np.ones((16, 16), bool))


def bare(one):
    """A scene without anything on its map."""
    nowhere = np.full((1, one.team, 2), -99)  # off the map
    return copied(
        one,
        trails=nowhere,
        in_view=np.zeros_like(one.in_view),
        linked=np.zeros_like(one.linked),
        lidar_range=0.0,
        radio=("none", 0.0),
    )


def test_what_is_known_is_white_or_black_and_the_rest_is_dim():
    one = bare(scene(steps=10))
    picture = main_map(one)
    for cell in np.ndindex(one.shape):
        table = HIDDEN if one.union[cell] == UNKNOWN else KNOWN
        assert np.array_equal(pixel(picture, one.shape, cell), table[one.truth[cell]]), cell
    assert KNOWN[FREE].min() > HIDDEN[FREE].max() > HIDDEN[OCCUPIED].max() > KNOWN[OCCUPIED].max()


def test_the_cells_in_view_take_on_the_colour_of_their_uav():
    one = scene(steps=0, floorplan=OPEN, team=1, **{"radio.model": "none"})
    row, col = one.cells[0]
    picture, colour = main_map(one), uav_colours(1)[0].astype(int)
    seen = [cell for cell in np.argwhere(one.in_view[0]) if abs(cell - (row, col)).sum() == 2]
    assert seen
    for cell in seen:
        tinted = pixel(picture, one.shape, cell)
        assert np.array_equal(np.argsort(tinted), np.argsort(colour))
        assert tinted.mean() > HIDDEN[FREE].mean()
    assert np.array_equal(one.in_view[0], scan(one.truth, (row, col), one.lidar_range) != UNKNOWN)


@pytest.mark.parametrize("team", [1, 4, 16, 64])
def test_a_disc_of_each_uav_s_colour_is_at_its_cell(team):
    one = copied(scene(steps=3, team=team, floorplan=OPEN), linked=np.zeros((team, team), bool))
    picture = main_map(one)
    assert len({tuple(colour) for colour in uav_colours(team).tolist()}) == team
    for agent in range(team):
        spot = pixel(picture, one.shape, one.cells[agent], (-0.31, 0.0))  # above the number, within the disc
        assert abs(spot - uav_colours(team)[agent]).max() < 30, agent


def test_a_link_is_a_dark_line_between_two_uavs():
    one = bare(scene(steps=0, floorplan=OPEN, team=2))
    cells = np.array([(4, 4), (4, 11)])
    here = copied(one, trails=cells[None], union=one.truth.copy(), linked=np.array([[False, True], [True, False]]))
    apart = copied(here, linked=np.zeros((2, 2), bool))
    for towards in (1.8, 3.7, 5.2):
        assert abs(pixel(main_map(here), one.shape, cells[0], (0, towards)) - INK).max() < 90
        assert np.array_equal(pixel(main_map(apart), one.shape, cells[0], (0, towards)), KNOWN[FREE])


def test_a_trail_fades_with_age():
    one = bare(scene(steps=0, floorplan=OPEN, team=1))
    path = np.array([(8, col) for col in range(2, 14)])[:, None]
    picture = main_map(copied(one, trails=path, union=one.truth.copy()))
    colour = uav_colours(1)[0].astype(int)
    away = [abs(pixel(picture, one.shape, (8, col)) - colour).sum() for col in range(2, 13)]
    assert away == sorted(away, reverse=True)
    assert 0 < away[-1] < away[0] < abs(colour - 255).sum()


def test_an_own_map_shows_nothing_that_its_uav_does_not_know():
    """Whatever changes in the true map, in the team's, or in a teammate's mind: the panel is the same."""
    one = scene(steps=14, seed=2)
    own = [panel(one, agent) for agent in range(4)]
    rng = np.random.default_rng(0)
    for agent in range(4):
        hidden = one.beliefs[agent] == UNKNOWN
        assert hidden.any()
        other = copied(one, step=one.step + 1, coverage=0.0)
        other.truth[hidden] = rng.integers(1, 3, hidden.sum())
        other.union[hidden] = rng.integers(0, 3, hidden.sum())
        mates = np.arange(4) != agent
        other.beliefs[mates] = rng.integers(0, 3, other.beliefs[mates].shape)
        other.trails[:, mates] = rng.integers(0, 16, other.trails[:, mates].shape)
        other.in_view[mates] = ~other.in_view[mates]
        other.linked[:] = ~other.linked
        assert np.array_equal(panel(other, agent), own[agent])
        assert not np.array_equal(main_map(other), main_map(one))


def test_an_own_map_shows_the_belief_and_where_teammates_were_last_heard():
    one = bare(scene(steps=6, team=2, floorplan=OPEN))
    one.heard_age[:] = -1
    picture = panel(one, 0, titled=False)
    for cell in np.ndindex(one.shape):
        assert np.array_equal(pixel(picture, one.shape, cell, (0.1, 0.1)), KNOWN[one.beliefs[0][cell]])
    heard = copied(one)
    heard.heard_age[0, 1], heard.heard_cell[0, 1] = 0, (5, 5)
    marked = panel(heard, 0, titled=False) != picture
    assert marked.any()
    rows, cols, _ = np.nonzero(marked)
    assert {4, 5, 6} >= set(rows * 16 // len(picture)) and {4, 5, 6} >= set(cols * 16 // len(picture))  # noqa: PT018
    heard.heard_age[0, 1] = 50
    faded = panel(heard, 0, titled=False)
    assert (faded.astype(int).sum()) > panel(copied(heard, heard_age=np.where(one.heard_age < 0, 0, 0)), 0, False).sum()


def test_a_uav_that_has_ended_is_paler_unless_the_team_has_reached_its_end_together():
    one = copied(scene(steps=4, team=3, floorplan=OPEN), linked=np.zeros((3, 3), bool))
    one.ends[1] = End.COLLISION
    picture, colour = main_map(one), uav_colours(3)[1]
    spot = pixel(picture, one.shape, one.cells[1], (-0.31, 0.0))
    assert abs(spot - paler(colour)).max() < 30
    assert not np.array_equal(panel(one, 1), panel(copied(one, ends=np.zeros(3, np.uint8)), 1))
    together = copied(one, ends=np.full(3, End.GOAL, np.uint8))
    assert abs(pixel(main_map(together), one.shape, one.cells[1], (-0.31, 0.0)) - colour).max() < 30


def test_all_frames_of_an_episode_have_one_size():
    world, trails = flown(steps=0, team=5)
    rng, shapes = np.random.default_rng(1), set()
    for _ in range(25):
        world.step(rng.integers(0, 5, (1, 5)))
        trails.add(world.state.cell[0])
        picture = paint(scene_of(world, 0, trails))
        shapes.add((picture.shape, picture.dtype))
    assert len(shapes) == 1


@pytest.mark.parametrize(
    ("shape", "team"),
    [((16, 16), 64), ((400, 400), 4), ((30, 90), 16), ((90, 30), 3), ((250, 200), 64), ((1500, 40), 2), ((6, 6), 2)],
)
def test_every_size_of_map_and_team_is_pictured(shape, team):
    one = scene(steps=2, floorplan=random_plan(shape, walls=0.05), team=team, **{"lidar.range": 8.0})
    picture, layout = paint(one), layout_of(shape, team)
    assert picture.shape == (layout.height, layout.width, 3)
    assert picture.shape[0] <= 2400
    assert picture.shape[1] <= 2400
    boxes = [layout.main, *layout.panels]
    assert (len(layout.panels), layout.missing) == (min(team, PANELS), max(team - PANELS, 0))
    taken = np.zeros(picture.shape[:2], int)
    for top, left, height, width in boxes:
        assert min(top, left) > 10
        assert max(top + height - picture.shape[0], left + width - picture.shape[1]) < -10
        assert abs(height / width - shape[0] / shape[1]) < 0.1 * shape[0] / shape[1] or min(height, width) < 40
        taken[top : top + height, left : left + width] += 1
    assert taken.max() == 1
    for edge in (picture[0], picture[-1], picture[:, 0], picture[:, -1]):
        assert (edge == PAGE).all()


def test_a_corridor_one_cell_wide_is_pictured():
    free = np.zeros((3, 40), bool)
    free[1, 1:-1] = True
    one = scene(steps=5, team=2, floorplan=plan(free))
    picture = main_map(one)
    assert picture.shape[1] == 40 * (picture.shape[0] // 3)
    known = np.argwhere(one.union == OCCUPIED)
    assert len(known)
    assert pixel(picture, one.shape, known[0], (0.4, 0.4)).max() < HIDDEN[OCCUPIED].min()


def test_no_pattern_of_its_own_at_any_scale():
    """A checkerboard finer than the pixels is the grey between."""
    fine = plan(np.indices((2000, 30)).sum(axis=0) % 2 == 0)
    one = bare(scene(steps=0, team=1, floorplan=plan(np.ones((2000, 30), bool))))
    picture = main_map(copied(one, truth=fine.truth, union=np.zeros_like(one.union)))
    middle = (HIDDEN[FREE].astype(int) + HIDDEN[OCCUPIED]) / 2
    assert abs(picture.astype(int).mean(axis=(0, 1)) - middle).max() < 2
    assert abs(picture.astype(int) - middle).max() < 13


def test_the_first_uavs_keep_their_colours_in_larger_teams():
    for team in (1, 4, 7, 30):
        assert np.array_equal(uav_colours(64)[:team], uav_colours(team))


def test_a_scene_is_plain_arrays_and_needs_no_trails():
    world, _ = flown(steps=3)
    one = scene_of(world, 0, title="mine")
    assert one.trails.shape == (1, 4, 2)
    assert one.title == "mine"
    assert not any(isinstance(getattr(one, field.name), type(world)) for field in dataclasses.fields(one))
    assert paint(one).dtype == np.uint8


def test_nearly_everything_is_not_everything():
    assert [floored_percent(share) for share in (0.0, 0.123, 0.99999, 1.0)] == ["0.0%", "12.3%", "99.9%", "100.0%"]


def test_trails_forget():
    trails = Trails((3, 3))
    trails.restart(np.array([(0, 0)]))
    for step in range(100):
        trails.add(np.array([(step, 1)]))
    assert trails.cells.shape == (40, 1, 2)
    assert trails.cells[-1, 0].tolist() == [99, 1]
    trails.restart(np.array([(2, 2)]))
    assert trails.cells.tolist() == [[[2, 2]]]


@pytest.mark.parametrize("reach", [4, 12, 100])
def test_the_links_drawn_of_a_large_team_are_few_and_join_the_same_uavs(reach):
    cells = np.random.default_rng(reach).permutation(1600)[:60]
    places = np.stack(np.divmod(cells, 40), axis=1)
    away = np.hypot(*np.moveaxis(places[:, None] - places, -1, 0))
    one = copied(scene(team=60, floorplan=plan(np.ones((40, 40), bool))), trails=places[None])
    one = copied(one, linked=(away <= reach) & ~np.eye(60, dtype=bool))
    drawn = nearest_links(one)
    assert (drawn == drawn.T).all()
    assert not (drawn & ~one.linked).any()
    assert drawn.sum() <= 6 * 60
    parts, drawn_parts = (connected_components(links)[1] for links in (one.linked, drawn))
    assert (parts == drawn_parts).all()


@pytest.mark.parametrize("shape", [(1, 1), (60, 1), (5, 2)])
def test_a_caption_fits_over_the_narrowest_map(shape):
    one = copied(scene(steps=0, team=1, floorplan=plan(np.ones(shape, bool))), title="1")
    picture = paint(copied(one, ends=np.array([End.GOAL], np.uint8)))
    caption = picture[: MARGIN + CAPTION - 22].min(axis=(0, 2)) < 255
    assert not caption[:MARGIN].any()
    assert caption[MARGIN : MARGIN + 10].any()
    assert not caption[-MARGIN + 1 :].any()


def test_the_home_base_is_a_landing_pad_on_every_map_and_its_coverage_is_told():
    one = bare(scene(steps=0, floorplan=OPEN, team=2, **{"base.at": (4, 11)}))
    none = dataclasses.replace(one, base=None)
    changed = np.argwhere((paint(one) != paint(none)).any(axis=2))
    layout = layout_of(one.shape, 2)
    for box in (layout.main, *layout.panels):
        cell = box.width / 16
        middle = np.array([box.top + 4.5 * cell, box.left + 11.5 * cell])
        here = changed[np.hypot(*(changed - middle).T) < 2 * cell]
        assert len(here) > 100
        assert np.abs(here.mean(axis=0) - middle).max() < 1.5
    assert (changed[:, 0] < MARGIN + CAPTION).any()


def test_the_home_base_is_linked_with_the_nearest_uav_of_each_group_in_contact():
    linked = np.zeros((5, 5), bool)
    linked[[0, 1], [1, 0]] = True
    cells, base = np.array([(0, 9), (0, 4), (0, 1), (5, 5), (0, 2)]), np.array([0, 0])
    contact = np.array([True, True, True, False, True])
    assert base_links(linked, contact, cells, base).tolist() == [False, True, True, False, True]
    assert not base_links(linked, np.zeros(5, bool), cells, base).any()
    one = bare(scene(steps=0, floorplan=OPEN, team=2, **{"base.at": (4, 4)}))
    one = copied(one, trails=np.array([(4, 11), (12, 12)])[None], union=one.truth.copy())
    here, apart = (copied(one, base_linked=np.array([found, False])) for found in (True, False))
    spot = pixel(main_map(here), one.shape, np.array((4, 7)), (0, 0.3))
    assert abs(spot - INK).max() < 90
    assert np.array_equal(pixel(main_map(apart), one.shape, np.array((4, 7)), (0, 0.3)), KNOWN[FREE])


def test_a_stopped_uav_is_crossed_out():
    one = copied(scene(steps=4, team=20, floorplan=OPEN), linked=np.zeros((20, 20), bool))
    one.ends[:2] = End.COLLISION, End.STOPPED
    crosses = np.argwhere(np.abs(main_map(one).astype(int) - STOP).max(axis=2) < 12)
    side = len(main_map(one)) / 16
    assert len(crosses) > 20
    assert np.hypot(*((crosses / side) - one.cells[1] - 0.5).T).max() < 1.3


def test_a_prior_map_is_faint_under_what_is_unknown():
    one = bare(scene(steps=6, seed=3, team=2))
    assert one.prior is None
    prior = np.random.default_rng(0).integers(FREE, OCCUPIED + 1, one.shape).astype(np.uint8)
    seen = copied(one, prior=prior)
    main, own = main_map(seen), panel(seen, 1, titled=False)
    for cell in np.ndindex(one.shape):
        dim = {(FREE, OCCUPIED): ONLY_PRIOR, (OCCUPIED, FREE): ONLY_TRUTH}
        hidden = dim.get((one.truth[cell], prior[cell]), HIDDEN[one.truth[cell]])
        expected = hidden if one.union[cell] == UNKNOWN else KNOWN[one.truth[cell]]
        assert np.array_equal(pixel(main, one.shape, cell), expected), cell
        below = HIDDEN[OCCUPIED] if prior[cell] == OCCUPIED else KNOWN[UNKNOWN]
        expected = below if one.beliefs[1][cell] == UNKNOWN else KNOWN[one.beliefs[1][cell]]
        assert np.array_equal(pixel(own, one.shape, cell, (0.1, 0.1)), expected), cell
