"""Tours: the beam search on bitboards against plain searches, and the tour features of the moves."""

from collections import deque
from itertools import pairwise

import networkx as nx
import numpy as np
import pytest
from numpy.typing import NDArray

from indoor_explorers.env import FREE, OCCUPIED, PRESETS, UNKNOWN
from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import MOVES
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.search.bitsets import STRIDE, board_size, neighbour_pairs, without
from indoor_explorers.env.sensing.lidar import view_gain
from indoor_explorers.learners.dddqn.observation.beam import Aim, follow_tour, new_beam, shortest_tour
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import TOURS
from indoor_explorers.learners.dddqn.observation.map_prior import UNLIKELY, assume_obstacles
from indoor_explorers.learners.dddqn.observation.memory import new_memory
from indoor_explorers.learners.dddqn.observation.scales import scratch, sensor
from indoor_explorers.learners.dddqn.observation.tours import sectors
from indoor_explorers.planners.toolbox.information.optimistic_views import update_views
from tests.learners.dddqn.observation.test_observe import Watcher
from tests.learners.dddqn.rooms import random_belief

Cells = frozenset[tuple[int, int]]
SIGHT = ObservationConfig(layers=("unknown",), coarse=0, sides=False, gains=False, visits=False)


def bits(cells: Cells) -> NDArray[np.uint64]:
    words = np.zeros(4, np.uint64)
    for r, c in cells:
        words[(r * STRIDE + c) >> 6] |= np.uint64(1) << np.uint64((r * STRIDE + c) & 63)
    return words


def cells_of(words: NDArray[np.uint64]) -> Cells:
    flat = np.flatnonzero(np.unpackbits(words.view(np.uint8), bitorder="little"))
    return frozenset((int(k) // STRIDE, int(k) % STRIDE) for k in flat)


class Room:
    """A small room whose unknown cells are taken to be free, with its views and passages."""

    def __init__(self, belief: Belief, chance: NDArray[np.uint8] | None = None) -> None:
        self.belief = belief
        self.chance = np.full(belief.shape, 255, np.uint8) if chance is None else chance
        memory = new_memory(1, belief.shape, ObservationConfig())
        lens, stale = sensor(3.0), np.zeros((16, 16), np.uint8)
        self.views, self.passages = memory.views[0], memory.passages[0]
        work = scratch(belief.shape, lens)
        self.obstructed = assume_obstacles(belief, self.chance, work.layer)
        reach, obstacles = lens.reach + 1, memory.obstacles[0]
        update_views(work.layer, STRIDE, lens.lidar, work.scan, reach, stale, obstacles, self.views, self.passages)

    def seen(self, cell: tuple[int, int]) -> Cells:
        return cells_of(self.views[cell[0] * STRIDE + cell[1]])

    def shortest(self, start: tuple[int, int], unseen: Cells, rest: int) -> int:
        """Steps of the shortest tour from ``start``, which counts as the first, by breadth-first search."""
        first = (start, unseen - self.seen(start))
        queue, steps = deque([first]), {first: 1}
        while queue:
            cell, left = queue.popleft()
            if len(left) <= rest:
                return steps[cell, left]
            for down, right in MOVES[:4].tolist():
                after = (cell[0] + down, cell[1] + right)
                inside = 0 <= after[0] < self.belief.shape[0] and 0 <= after[1] < self.belief.shape[1]
                state = (after, left - self.seen(after)) if inside and self.belief[after] != OCCUPIED else None
                if state is not None and state not in steps:
                    steps[state] = steps[cell, left] + 1
                    queue.append(state)
        raise AssertionError("no tour")


@kernel()
def measured(words: np.ndarray) -> tuple[int, int]:
    """The size of a set and its pairs of neighbours, for Python."""
    cells = without(words, np.zeros(4, np.uint64))
    return board_size(cells), neighbour_pairs(cells)


def test_sets_are_counted_with_their_neighbours() -> None:
    rng = np.random.default_rng(2)
    for share in (0.0, 0.1, 0.5, 1.0):
        inside = np.argwhere(rng.random((16, 16)) < share).tolist()
        cells = frozenset((r, c) for r, c in inside)
        forward = ((0, 1), (1, -1), (1, 0), (1, 1))
        expected = sum((r + down, c + right) in cells for r, c in cells for down, right in forward)
        assert measured(bits(cells)) == (len(cells), expected)


def small_belief(seed: int) -> tuple[Belief, tuple[int, int]]:
    belief, _ = random_belief(np.random.default_rng(seed), 7, 8)
    free = np.argwhere(belief == FREE)
    row, col = free[seed % len(free)].tolist()
    return belief, (row, col)


def passable(belief: Belief) -> nx.Graph:
    """Return the graph of the cells that are not known obstacles."""
    graph = nx.grid_2d_graph(*belief.shape)
    graph.remove_nodes_from([tuple(cell) for cell in np.argwhere(belief == OCCUPIED).tolist()])
    return graph


def test_views_and_passages_follow_the_belief() -> None:
    for seed in range(8):
        belief, _ = small_belief(seed)
        room = Room(belief)
        assert room.obstructed == (belief == OCCUPIED).any()
        graph = passable(belief)
        for r, c in np.argwhere(belief != OCCUPIED).tolist():
            found = {divmod(int(k), STRIDE) for k in room.passages[r * STRIDE + c] if k >= 0}
            assert found == set(graph[(r, c)])
            unknown = {(i, j) for i, j in room.seen((r, c)) if belief[i, j] == UNKNOWN} - {(r, c)}
            assert len(unknown) == view_gain(belief, (r, c), 3.0)


def test_probable_obstacles_are_assumed_to_be_obstacles() -> None:
    for seed in range(4):
        belief, _ = small_belief(seed)
        unlikely = np.random.default_rng(seed).random(belief.shape) < 0.3
        assumed = Room(belief, np.where(unlikely, UNLIKELY - 1, UNLIKELY).astype(np.uint8))
        told = Room(np.where(unlikely & (belief == UNKNOWN), OCCUPIED, belief).astype(np.uint8))
        assert np.array_equal(assumed.views, told.views)
        assert np.array_equal(assumed.passages, told.passages)
        assert assumed.obstructed == (belief == OCCUPIED).any()


@pytest.mark.parametrize(("width", "longer"), [(8, 1.0), (64, 0.2)])
def test_tours_are_valid_and_the_nearer_to_the_shortest_the_wider_the_beam(width: int, longer: float) -> None:
    beam, extra = new_beam(width), []
    for seed in range(40):
        belief, start = small_belief(seed)
        room = Room(belief)
        reach = frozenset().union(*(room.seen(cell) for cell in nx.node_connected_component(passable(belief), start)))
        unseen = frozenset((r, c) for r, c in reach if belief[r, c] == UNKNOWN)
        aim = Aim(rest=1.0, halfway=5.0, isolation=8.0)
        at = start[0] * STRIDE + start[1]
        tour = shortest_tour(at, bits(unseen), room.views, room.passages, aim, beam)
        assert tour.finished
        path = [divmod(int(k), STRIDE) for k in beam.path[: int(tour.steps)]]
        assert path[0] == start
        assert all(abs(a[0] - b[0]) + abs(a[1] - b[1]) == 1 for a, b in pairwise(path))
        left = [unseen - frozenset().union(*map(room.seen, path[: k + 1])) for k in range(len(path))]
        assert len(left[-1]) <= 1 < min([len(cells) for cells in left[:-1]], default=2)
        assert tour.delay == sum(map(len, left))
        assert tour.halfway == next(k for k, cells in enumerate(left, 1) if len(cells) <= 5)
        extra.append(tour.steps - room.shortest(start, unseen, 1))
    assert min(extra) >= 0
    assert np.mean(extra) < longer


def test_a_kept_tour_is_worth_what_is_left_of_it_and_nothing_when_blocked() -> None:
    belief = np.full((3, 12), UNKNOWN, np.uint8)
    belief[:, :4] = FREE
    room = Room(belief)
    unseen, aim = frozenset((r, c) for r in range(3) for c in range(4, 12)), Aim(0.0, 8.0, 8.0)
    path = np.full(41, -1)
    path[:8] = [STRIDE + c for c in range(2, 10)]
    tour = follow_tour(STRIDE + 1, path, bits(unseen), room.views, room.passages, aim)
    assert tour.finished
    assert tour.steps == 8
    assert not follow_tour(STRIDE + 6, path, bits(unseen), room.views, room.passages, aim).finished
    belief[:, 6] = OCCUPIED
    blocked = Room(belief)
    assert not follow_tour(STRIDE + 1, path, bits(unseen), blocked.views, blocked.passages, aim).finished


def test_the_features_compare_the_moves() -> None:
    belief = np.full((5, 12), UNKNOWN, np.uint8)
    belief[:, :7] = FREE
    watcher = Watcher(SIGHT, (5, 12))
    watcher.look(belief, (2, 3))
    features = {name: watcher.moves[0, :, 1 + k] for k, name in enumerate(TOURS)}
    east = next(k for k in range(4) if MOVES[k].tolist() == [0, 1])
    assert features["a tour to the goal was found"].tolist() == [1, 1, 1, 1]
    assert features["it is the shortest"][east] == 1
    assert features["its steps beyond the shortest"].argmin() == east
    assert features["its steps"].min() == features["its steps"][east] > 0
    np.testing.assert_allclose(features["unknown share"], 25 / 60)


def test_blocked_moves_say_so_and_others_do_not() -> None:
    belief = np.full((4, 4), FREE, np.uint8)
    belief[3, 3] = UNKNOWN
    watcher = Watcher(SIGHT, (4, 4))
    watcher.look(belief, (0, 0))
    beyond = watcher.moves[0, :, 1 + TOURS.index("its steps beyond the shortest")]
    blocked = watcher.moves[0, :, 0] > 0
    assert blocked.sum() == 2
    assert (beyond[blocked] == 1).all()
    assert (beyond[~blocked] < 1).all()


def test_cells_closer_to_a_teammate_are_left_to_it() -> None:
    belief = np.full((3, 15), FREE, np.uint8)
    belief[:, :2] = belief[:, 13:] = UNKNOWN
    west = next(k for k in range(4) if MOVES[k].tolist() == [0, -1])
    alone, linked = Watcher(SIGHT, (3, 15)), Watcher(SIGHT, (3, 15))
    alone.look(belief, (1, 8))
    linked.look(belief, (1, 8), [(1, 12), (0, 0)], (0, -1))
    steps = 1 + TOURS.index("its steps")
    assert linked.moves[0, west, steps] < alone.moves[0, west, steps]
    assert linked.moves[0, :, 1 + TOURS.index("it is the shortest")].argmax() == west


def test_tours_lead_elsewhere_while_a_teammate_is_in_the_way() -> None:
    belief = np.full((5, 12), UNKNOWN, np.uint8)
    belief[:, :7] = FREE
    watcher = Watcher(SIGHT, (5, 12))
    east, beyond = 3, 1 + TOURS.index("its steps beyond the shortest")
    assert MOVES[east].tolist() == [0, 1]
    shortest = []
    for pushes in (False, True, False, False, False, False):
        watcher.memory.aim(np.array([[2, 3]]), np.array([east if pushes else 4]))
        watcher.look(belief, (2, 3))
        assert watcher.moves[0, east, 0] == (watcher.moves[0, east, beyond] == 1)
        shortest.append(watcher.moves[0, :, beyond].argmin() == east)
    assert shortest == [True, False, False, False, False, True]


@pytest.mark.parametrize(("radio", "parted"), [("none", True), ("unlimited", False)])
def test_sectors_part_those_who_never_heard_of_each_other(radio: str, parted: bool) -> None:
    belief = np.full((15, 15), UNKNOWN, np.uint8)
    belief[5:10, 5:10] = FREE
    shares = {}
    for heard, ages in {"nobody": (-1, -1, -1), "all": (20, 20, -1)}.items():
        watcher = Watcher(SIGHT, (15, 15), radio=radio)
        watcher.look(belief, (7, 7), [(0, 0), (0, 14), (0, 0)], ages)
        shares[heard] = watcher.moves[0, :, 1 + TOURS.index("unknown share")].max()
    assert (shares["nobody"] < shares["all"]) == parted


def test_sectors_are_as_large_as_each_other_and_meet_in_the_middle() -> None:
    room = PRESETS["thesis-team-4-radio-0"]
    for team in (2, 3, 4):
        owner = sectors((16, 16), room.model_copy(update={"team": team}))
        sizes = np.bincount(owner.ravel())
        assert len(sizes) == team
        assert sizes.max() - sizes.min() <= 1
        assert len(np.unique(owner[6:10, 6:10])) == team
    for name, parted in {"thesis-team-4-radio-1": True, "thesis-team-2": True, "thesis-team-4": False}.items():
        assert (sectors((16, 16), PRESETS[name]) >= 0).all() == parted


def test_equally_near_cells_are_left_to_the_lower_number() -> None:
    belief = np.full((3, 15), FREE, np.uint8)
    belief[:, :2] = UNKNOWN
    belief[1, 14] = UNKNOWN  # left where all else is a teammate's
    shares = {}
    for mate, ages in {"lower": (0, -1), "higher": (-1, -1, -1, 0)}.items():
        watcher = Watcher(SIGHT, (3, 15))
        watcher.look(belief, (1, 7), [(0, 6)] * len(ages), ages)  # UAV 2: as near to the west, farther from the east
        shares[mate] = watcher.moves[0, :, 1 + TOURS.index("unknown share")].max()
    assert shares["lower"] < shares["higher"]


def test_a_tour_found_before_is_kept_while_nothing_better_is_found() -> None:
    rng = np.random.default_rng(4)
    for _ in range(6):
        belief, (row, col) = random_belief(rng, 16, 16)
        watcher = Watcher(SIGHT, (16, 16))
        watcher.look(belief, (row, col))
        kept = [int(cell) for cell in watcher.memory.tour[0, 0] if cell >= 0]
        if not kept:
            continue
        before = watcher.moves[0, :, 1 + TOURS.index("its steps")].copy()
        move = next(k for k in range(4) if (row + MOVES[k, 0]) * STRIDE + col + MOVES[k, 1] == kept[0])
        if belief[divmod(kept[0], STRIDE)] != FREE:
            continue
        watcher.look(belief, divmod(kept[0], STRIDE))
        after = watcher.moves[0, watcher.moves[0, :, 0] == 0, 1 + TOURS.index("its steps")]
        assert after.min() <= before[move] - 1 / 48 + 1e-6


@pytest.mark.parametrize("shape", [(17, 4), (4, 40)])
def test_large_maps_have_no_tours(shape: tuple[int, int]) -> None:
    belief = np.full(shape, UNKNOWN, np.uint8)
    belief[:3, :3] = FREE
    watcher = Watcher(SIGHT, shape)
    watcher.look(belief, (1, 1))
    assert watcher.memory.views.shape[1] == 0
    assert not watcher.moves[0, :, 1:].any()
