"""Generated maps: connected for every legal setting, the same for the same seed, and built as their settings say."""

import json
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.maps.generators.cave import joined
from indoor_explorers.env.maps.generators.furniture import spares_the_way
from indoor_explorers.env.maps.generators.offices import shares
from indoor_explorers.env.maps.generators.rooms import Rectangle, neighbours, partition
from indoor_explorers.env.maps.sources import (
    CaveMaps,
    FloorsMaps,
    HallsMaps,
    HomesMaps,
    MazeMaps,
    OfficesMaps,
    RoomsMaps,
)
from indoor_explorers.env.search.connected_parts import connected_parts

KINDS = (RoomsMaps, OfficesMaps, HallsMaps, HomesMaps, CaveMaps, MazeMaps)


def span(least, most):
    return st.tuples(st.integers(least, most), st.integers(least, most)).map(sorted).map(tuple)


@st.composite
def rooms(draw):
    sizes = draw(span(1, 12))
    corridor = draw(st.integers(1, sizes[0]))
    sides = {name: draw(st.integers(max(5, sizes[0] + 2), 60)) for name in ("height", "width")}
    return RoomsMaps(
        room_size=sizes, corridor=corridor, door=draw(st.integers(1, corridor)), loops=draw(st.floats(0, 1)), **sides
    )


@st.composite
def offices(draw):
    depth, width, corridor = draw(span(1, 9)), draw(span(1, 9)), draw(st.integers(1, 5))
    least = max(5, corridor + 3 + max(depth[0], width[0]))
    extra = {name: draw(st.floats(0, 1)) for name in ("links", "meeting")}
    return OfficesMaps(
        height=draw(st.integers(least, 70)),
        width=draw(st.integers(least, 70)),
        corridor=corridor,
        room_depth=depth,
        room_width=width,
        door=draw(span(1, 4)),
        crossing=draw(st.integers(1, 80)),
        furniture=draw(st.floats(0, 0.5)),
        **extra,
    )


caves = st.builds(
    CaveMaps,
    height=st.integers(5, 60),
    width=st.integers(5, 60),
    rock=st.floats(0, 0.6),
    smoothing=st.integers(0, 6),
    chamber=st.integers(1, 5000),
)


@st.composite
def mazes(draw):
    corridor, wall = draw(st.integers(1, 5)), draw(st.integers(1, 4))
    sides = {name: draw(st.integers(max(5, corridor + 2 * wall), 60)) for name in ("height", "width")}
    return MazeMaps(corridor=corridor, wall=wall, braid=draw(st.floats(0, 1)), **sides)


@st.composite
def halls(draw):
    sides = {name: draw(st.integers(10, 60)) for name in ("height", "width")}
    sizes = {name: draw(span(1, 12)) for name in ("aisle", "rack_length", "room_depth", "room_width")}
    shares = {"side_rooms": draw(st.floats(0, 1)), "furniture": draw(st.floats(0, 0.5))}
    content = draw(st.sampled_from((None, "columns", "desks", "racks")))
    return HallsMaps(content=content, spacing=draw(span(3, 15)), **sizes, **shares, **sides)


@st.composite
def homes(draw):
    sizes = draw(span(1, 12))
    sides = {name: draw(st.integers(max(5, sizes[0] + 2), 60)) for name in ("height", "width")}
    shares = {name: draw(st.floats(0, 1)) for name in ("loops", "wide")}
    return HomesMaps(
        room_size=sizes, door=draw(st.integers(1, 5)), furniture=draw(st.floats(0, 0.5)), **shares, **sides
    )


every_map = settings(max_examples=150, deadline=None)
seeds = st.integers(0, 2**32)


def one_connected_floor(maps, seed):
    """Assert that a seed has one map, of the size set, with one free part inside a solid border; return it."""
    plan = maps.floorplan(0, seed)
    assert plan.shape == (maps.height, maps.width)
    assert plan.name == maps.source
    assert len(connected_parts(plan.truth == FREE)[1]) == 2
    inner = np.zeros(plan.shape, np.bool_)
    inner[1:-1, 1:-1] = True
    assert (plan.truth[~inner] == OCCUPIED).all()
    assert maps.floorplan(0, seed).digest == plan.digest
    return plan


@every_map
@given(st.one_of(rooms(), offices(), halls(), homes(), caves, mazes()), seeds)
def test_any_legal_setting_gives_one_connected_floor_inside_walls(maps, seed):
    one_connected_floor(maps, seed)


@pytest.mark.parametrize("kind", [*KINDS, FloorsMaps])
def test_seeds_and_attempts_make_different_maps(kind):
    digests = {kind().floorplan(0, seed, attempt).digest for seed in range(20) for attempt in range(2)}
    assert len(digests) == 40
    assert kind().generated


@pytest.mark.parametrize("kind", KINDS)
def test_large_and_lopsided_maps_are_connected(kind):
    for height, width in ((1000, 1000), (16, 2048), (700, 24)):
        plan = kind(height=height, width=width).floorplan(0, 3)
        assert plan.shape == (height, width)
        assert plan.main_part.sum() == (plan.truth == FREE).sum() > 0.15 * height * width


def test_another_process_makes_the_same_maps():
    program = (
        "import json\n"
        "from indoor_explorers.env.maps import sources\n"
        "names = ('RoomsMaps', 'OfficesMaps', 'HallsMaps', 'HomesMaps', 'CaveMaps', 'MazeMaps')\n"
        "kinds = [getattr(sources, name) for name in names]\n"
        "sides = ((64, 64), (30, 97))\n"
        "found = [k(height=h, width=w).floorplan(0, s).digest for k in kinds for h, w in sides for s in range(3)]\n"
        "import sys; sys.stdout.write(json.dumps(found))\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=300, check=True)
    here = [
        kind(height=height, width=width).floorplan(0, seed).digest
        for kind in KINDS
        for height, width in ((64, 64), (30, 97))
        for seed in range(3)
    ]
    assert json.loads(done.stdout) == here


@every_map
@given(mazes(), seeds)
def test_mazes_keep_corridor_and_wall(maps, seed):
    """Every run of free cells that a wall ends is a whole number of corridors and walls, less one wall."""
    free = maps.floorplan(0, seed).truth == FREE
    pitch = maps.corridor + maps.wall
    rows, cols = ((side - maps.wall) // pitch for side in (maps.height, maps.width))
    for lines in (free, free.T):
        for line in lines:
            edges = np.flatnonzero(np.diff(line.astype(np.int8)))
            assert ((edges[1::2] - edges[::2] + maps.wall) % pitch == 0).all()
    assert free.sum() >= rows * cols * maps.corridor**2


@every_map
@given(st.integers(5, 61), st.integers(5, 61), seeds)
def test_a_perfect_maze_is_a_tree_and_a_braided_one_has_no_dead_ends(height, width, seed):
    tree = MazeMaps(height=height, width=width, corridor=1, braid=0.0).floorplan(0, seed).truth == FREE
    ways = (tree[1:] & tree[:-1]).sum() + (tree[:, 1:] & tree[:, :-1]).sum()
    assert ways == tree.sum() - 1
    if min(height, width) < 7:
        return
    loops = MazeMaps(height=height, width=width, corridor=1, braid=1.0).floorplan(0, seed).truth == FREE
    padded = np.pad(loops, 1).astype(int)
    exits = padded[:-2, 1:-1] + padded[2:, 1:-1] + padded[1:-1, :-2] + padded[1:-1, 2:]
    assert (exits[loops] >= 2).all()


@every_map
@given(rooms(), seeds)
def test_rooms_are_entered_by_doors_alone(maps, seed):
    """Every corridor opens one door in each of its two rooms, and nothing else opens their walls."""
    rng = np.random.default_rng(seed)
    gap = maps.gap
    shape = (maps.height + 2 * gap - 2, maps.width + 2 * gap - 2)
    leaves = partition(rng, shape, *(size + 2 * gap for size in maps.room_size))
    assert sum(leaf.tall * leaf.wide for leaf in leaves) == shape[0] * shape[1]
    placed = [maps._room(rng, leaf) for leaf in leaves]
    openings = 0
    free = maps.draw(np.random.default_rng(seed))
    for room in placed:
        top, left = room.top - gap + 1, room.left - gap + 1
        assert maps.room_size[0] <= min(room.tall, room.wide) <= max(room.tall, room.wide) <= maps.room_size[1]
        assert free[top : top + room.tall, left : left + room.wide].all()
        for wall in (
            free[top - 1, left : left + room.wide],
            free[top + room.tall, left : left + room.wide],
            free[top : top + room.tall, left - 1],
            free[top : top + room.tall, left + room.wide],
        ):
            assert (connected_parts(wall[None])[1][1:] >= maps.door).all()
            openings += wall.sum()
    assert openings <= 2 * maps.door * len(neighbours(leaves, shape))


def test_a_tree_of_rooms_has_no_spare_corridor():
    few, many = (
        np.mean([(RoomsMaps(loops=loops).floorplan(0, seed).truth == FREE).sum() for seed in range(10)])
        for loops in (0.0, 1.0)
    )
    assert many > few


def test_neighbours_share_an_edge_and_not_just_a_corner():
    four = [Rectangle(0, 0, 2, 2), Rectangle(0, 2, 2, 3), Rectangle(2, 0, 1, 2), Rectangle(2, 2, 1, 3)]
    assert neighbours(four, (3, 5)).tolist() == [[0, 1], [0, 2], [1, 3], [2, 3]]
    assert neighbours([Rectangle(0, 0, 3, 5)], (3, 5)).shape == (0, 2)


def test_office_corridors_run_along_the_longer_side():
    plain = OfficesMaps(height=40, width=90, furniture=0.0, meeting=0.0)
    turned = plain.model_copy(update={"height": 90, "width": 40})
    for seed in range(10):
        free = plain.floorplan(0, seed).truth == FREE
        assert free[:, 1:-1].all(axis=1).sum() >= plain.corridor
        assert (turned.floorplan(0, seed).truth == FREE).tolist() == free.T.tolist()


def test_office_furniture_takes_about_its_share_and_blocks_nothing():
    bare = OfficesMaps(height=100, width=100, furniture=0.0, meeting=0.0)
    full = bare.model_copy(update={"furniture": 0.2})
    shares_ = []
    for seed in range(5):
        before, after = (maps.floorplan(0, seed).truth == FREE for maps in (bare, full))
        assert (before | ~after).all()
        assert len(connected_parts(after)[1]) == 2
        shares_.append(1.0 - after.sum() / before.sum())
    assert 0.06 < np.mean(shares_) < 0.2


@given(seeds, st.integers(1, 5), st.integers(1, 5))
@settings(max_examples=200, deadline=None)
def test_what_spares_the_way_never_parts_a_floor(seed, tall, wide):
    rng = np.random.default_rng(seed)
    free = np.pad(rng.random((10, 10)) < 0.7, 1)
    top, left = rng.integers(1, 11 - np.array([tall, wide]) + 1)
    free[top : top + tall, left : left + wide] = True
    parts = len(connected_parts(free)[1])
    if spares_the_way(free, top, left, tall, wide):
        free[top : top + tall, left : left + wide] = False
        assert len(connected_parts(free)[1]) <= parts  # one less where the rectangle was a part of its own


@given(seeds, st.integers(1, 300), st.integers(1, 20), span(1, 30))
def test_shares_add_up_and_keep_their_bounds_where_they_can(seed, total, count, bounds):
    parts = shares(np.random.default_rng(seed), total, count, *bounds)
    assert sum(parts) == total
    assert len(parts) == count
    if count * bounds[0] <= total <= count * bounds[1]:
        assert min(parts) >= bounds[0]
        assert max(parts) <= bounds[1]


@given(seeds, st.floats(0.05, 0.9), st.integers(1, 30))
@settings(max_examples=100, deadline=None)
def test_joining_keeps_the_large_parts_and_makes_one_of_them(seed, density, least):
    free = np.pad(np.random.default_rng(seed).random((20, 31)) < density, 1)
    free[5, 5] = True
    labels, sizes = connected_parts(free)
    out = joined(free, least)
    assert len(connected_parts(out)[1]) == 2
    kept = [label for label in range(1, len(sizes)) if sizes[label] >= least]
    assert out[np.isin(labels, kept)].all()
    assert not out[[0, -1]].any()
    assert not out[:, [0, -1]].any()


def test_nothing_free_stays_so():
    assert not joined(np.zeros((5, 5), np.bool_), 3).any()


def test_a_cave_of_nothing_but_rock_starts_from_less():
    for seed in range(20):
        assert (CaveMaps(height=8, width=8, rock=0.6).floorplan(0, seed).truth == FREE).mean() >= 0.15


def solids(free):
    """Return the number of solid parts of a mask that touch no border."""
    parts, sizes = connected_parts(~free)
    border = np.unique(np.concatenate([parts[0], parts[-1], parts[:, 0], parts[:, -1]]))
    return len(sizes) - 1 - len(border[border > 0])


def test_halls_have_the_content_and_the_rooms_that_are_set():
    plain = {"side_rooms": 0.0, "height": 40, "width": 60}
    for seed in range(5):
        columns, racks, desks = (
            HallsMaps(content=content, **plain).floorplan(0, seed).truth == FREE
            for content in ("columns", "racks", "desks")
        )
        assert (~columns[1:-1, 1:-1]).sum() == solids(columns) >= 6
        assert (~racks[1:-1, 1:-1]).sum() >= 8 * solids(racks) > 8
        assert 4 <= (~desks[1:-1, 1:-1]).sum() / solids(desks) <= 21
    rows = HallsMaps(side_rooms=1.0, content="columns", furniture=0.0, height=40, width=60, room_depth=(5, 5))
    for seed in range(5):
        free = rows.floorplan(0, seed).truth == FREE
        in_rooms = free[1].astype(np.int8)
        assert free[6].sum() == (np.diff(in_rooms) == 1).sum() >= 4  # a door for each room of the first row


def test_homes_have_a_door_for_each_room_and_wide_ones_if_asked():
    plain = {"furniture": 0.0, "loops": 0.0, "door": 1}
    for seed in range(5):
        narrow, wide = (HomesMaps(wide=share, **plain).floorplan(0, seed).truth == FREE for share in (0.0, 1.0))
        assert wide.sum() > narrow.sum() + 5
        closed = narrow.copy()
        walls = np.zeros_like(closed)
        walls[1:-1, 1:-1] = (closed[1:-1, :-2] & closed[1:-1, 2:] & ~closed[:-2, 1:-1] & ~closed[2:, 1:-1]) | (
            closed[:-2, 1:-1] & closed[2:, 1:-1] & ~closed[1:-1, :-2] & ~closed[1:-1, 2:]
        )
        closed[walls] = False
        assert len(connected_parts(closed)[1]) - 1 == (walls & narrow).sum() + 1  # a tree of rooms
