"""The observation: symmetric, complete, and computed from the UAV's own knowledge alone."""

import numpy as np
import pytest
from numpy.typing import NDArray

from indoor_explorers.env import FREE, UNKNOWN, World
from indoor_explorers.env.grid.arrays import Belief, read_only
from indoor_explorers.env.grid.cells import MOVES
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.env.search.frontiers import frontier_mask
from indoor_explorers.env.sensing.lidar import view_gain
from indoor_explorers.learners.dddqn.observation.config import LAYERS, Layer, ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import (
    GAINS,
    SYMMETRIES,
    VISITS,
    ObservationLayout,
    observation_layout,
    symmetries,
    turned,
)
from indoor_explorers.learners.dddqn.observation.memory import SPENT, ObservationMemory, new_memory, note
from indoor_explorers.learners.dddqn.observation.observe import observation_context, observe
from indoor_explorers.learners.dddqn.observation.scales import sensor
from indoor_explorers.learners.dddqn.observation.uav import Known
from tests.learners.dddqn.rooms import random_belief, small_room, some_prior

Cell = tuple[int, int]
#: All but the chance, which turns with the world only as far as the prior has learned that it should.
EVEN: tuple[Layer, ...] = tuple(layer for layer in LAYERS if layer != "chance")
EVERYTHING = ObservationConfig(layers=EVEN, identity=True, progress=True, tours=False)


class Watcher:
    """One UAV that observes, with up to two teammates."""

    def __init__(
        self, config: ObservationConfig, shape: tuple[int, int], lidar: float = 3.0, radio: str = "unlimited"
    ) -> None:
        self.layout: ObservationLayout = observation_layout(config)
        self.memory: ObservationMemory = new_memory(1, shape, config)
        scenario = small_room().with_settings({"team": 3, "lidar.range": lidar, "radio.model": radio})
        self._context = observation_context(config, shape, scenario, some_prior())
        self.scene = np.zeros((1, self.layout.scene), np.uint8)
        self.moves = np.zeros((1, 4, self.layout.features), np.float32)

    def look(
        self, belief: Belief, cell: Cell, mates: list[Cell] | None = None, ages: tuple[int, ...] = (-1, -1)
    ) -> None:
        """Observe as UAV 2, half-way through its steps."""
        known = Known(
            read_only(np.ascontiguousarray(belief)[None]),
            np.array([cell]),
            np.array([mates or [(0, 0), (0, 0)]]),
            np.array([ages]),
            np.array([2]),
            np.array([0.5]),
        )
        observe(known, self.memory, np.zeros(1, np.int64), self._context, self.scene, self.moves)

    def layer(self, name: Layer) -> NDArray[np.uint8]:
        at, side = self.layout.layers[LAYERS.index(name)], self.layout.crop
        return self.scene[0, at : at + side * side].reshape(side, side)


def watched(belief: Belief, cell: Cell, config: ObservationConfig = EVERYTHING, lidar: float = 3.0) -> Watcher:
    watcher = Watcher(config, belief.shape, lidar)
    watcher.look(belief, cell)
    return watcher


def turned_cell(cell: Cell, shape: tuple[int, int], symmetry: int) -> Cell:
    marked = np.zeros(shape)
    marked[cell] = 1
    row, col = np.argwhere(turned(marked, symmetry))[0].tolist()
    return row, col


@pytest.mark.parametrize("lidar", [1.0, 3.0, 7.0, 12.5])
@pytest.mark.parametrize("symmetry", range(SYMMETRIES))
def test_turning_the_world_permutes_the_numbers(symmetry: int, lidar: float) -> None:
    rng = np.random.default_rng(symmetry)
    tables = symmetries(EVERYTHING)
    for _ in range(5):
        belief, cell = random_belief(rng)
        mates = [tuple(place) for place in rng.integers((0, 0), belief.shape, (2, 2)).tolist()]
        visits = rng.integers(0, 6, belief.shape, dtype=np.uint8)
        found = []
        for g in (0, symmetry):
            watcher = Watcher(EVERYTHING, turned(belief, g).shape, lidar)
            for _ in range(2):  # the first look is a gain, which visits are forgotten at
                places = [turned_cell(mate, belief.shape, g) for mate in mates]
                watcher.look(turned(belief, g), turned_cell(cell, belief.shape, g), places, (0, 7))
                watcher.memory.visits[0] = turned(visits, g)
            watcher.look(turned(belief, g), turned_cell(cell, belief.shape, g), places, (0, 7))
            found.append(watcher)
        before, after = found
        assert np.array_equal(after.scene[0], before.scene[0, tables.scene[symmetry]])
        np.testing.assert_allclose(after.moves[0], before.moves[0, tables.moves[symmetry]], atol=1e-6)
        assert after.memory.nearest[0] == before.memory.nearest[0]


def test_moves_turn_with_the_world() -> None:
    for symmetry, row in enumerate(symmetries(EVERYTHING).action):
        for action in range(4):
            before, after = np.zeros((5, 5)), np.zeros((5, 5))
            before[tuple(2 + MOVES[action])] = 1
            after[tuple(2 + MOVES[row[action]])] = 1
            assert np.array_equal(turned(before, symmetry), after)


def test_it_depends_on_nothing_outside_the_belief() -> None:
    rng = np.random.default_rng(5)
    world = World(small_room(), 2)
    world.reset([1, 1])
    watchers = [Watcher(ObservationConfig(layers=LAYERS), (8, 8)) for _ in range(2)]
    for _ in range(30):
        views = [world.view(b, 0) for b in range(2)]
        world.state.truth[1][views[1].belief == UNKNOWN] = rng.integers(1, 3)
        for watcher, view in zip(watchers, views, strict=True):
            watcher.look(view.belief, view.cell)
        assert np.array_equal(views[0].belief, views[1].belief)
        assert np.array_equal(watchers[0].scene, watchers[1].scene)
        assert np.array_equal(watchers[0].moves, watchers[1].moves)
        world.state.truth[1] = world.state.truth[0]
        action = rng.choice(np.flatnonzero(views[0].legal))
        world.step(np.full((2, 1), action))


def test_the_maps_show_what_is_around() -> None:
    belief, (row, col) = random_belief(np.random.default_rng(8))
    watcher = watched(belief, (row, col))
    fine, coarse = watcher.layout.crop, watcher.layout.coarse

    def around(array: NDArray[np.bool_], side: int) -> NDArray[np.bool_]:
        return np.pad(array, side // 2)[row : row + side, col : col + side]

    assert np.array_equal(watcher.layer("unknown") == 255, around(belief == UNKNOWN, fine))
    assert np.array_equal(watcher.layer("free") == 255, around(belief == FREE, fine))
    assert np.array_equal(watcher.layer("frontier") == 255, around(frontier_mask(belief), fine))
    blocks = around(belief == UNKNOWN, 3 * coarse).reshape(coarse, 3, coarse, 3).sum(axis=(1, 3))
    shown = watcher.scene[0, watcher.layout.coarse_at :][: coarse * coarse].reshape(coarse, coarse)
    assert np.array_equal(shown, np.rint(255 * blocks / 9))


def test_the_distance_layer_counts_steps_to_the_nearest_frontier() -> None:
    belief, (row, col) = random_belief(np.random.default_rng(11))
    watcher = watched(belief, (row, col))
    steps = np.min([distance_field(belief, (r, c)) for r, c in np.argwhere(frontier_mask(belief)).tolist()], axis=0)
    shown = watcher.layer("distance")
    for r, c in np.argwhere((belief == FREE) & (steps < 1000)).tolist():
        i, j = r - row + 7, c - col + 7
        if 0 <= i < 15 and 0 <= j < 15:
            assert shown[i, j] == int(255 * steps[r, c] / (steps[r, c] + 8) + 0.5)


def test_teammates_are_shown_where_they_were_heard_and_fade() -> None:
    belief = np.full((13, 13), FREE, np.uint8)
    watcher = Watcher(EVERYTHING, (13, 13))
    watcher.look(belief, (6, 6), [(5, 6), (6, 9)], (0, 10))
    assert np.argwhere(watcher.layer("mates")).tolist() == [[6, 7]]
    assert np.argwhere(watcher.layer("mates_past")).tolist() == [[7, 10]]
    assert watcher.layer("mates_past")[7, 10] == int(255 * 0.95**10 + 0.5)
    watcher.look(belief, (6, 6), [(5, 6), (6, 9)], (-1, -1))
    assert watcher.layer("mates").sum() == watcher.layer("mates_past").sum() == 0


def test_identity_and_progress_say_who_and_how_far() -> None:
    belief = np.full((4, 5), FREE, np.uint8)
    belief[0] = UNKNOWN
    watcher = watched(belief, (2, 2))
    scene, layout = watcher.scene[0], watcher.layout
    assert np.flatnonzero(scene[layout.identity_at : layout.identity_at + 8]).tolist() == [2]
    assert scene[layout.progress_at : layout.scene].tolist() == [191, 128, 0]
    for _ in range(8):
        watcher.look(belief, (2, 2))
    assert scene[layout.progress_at + 2] == 128


def gains_behind(belief: Belief, cell: Cell, been: Cell, lidar: float) -> list[float]:
    """The six gains of a move to ``cell``, by their definition and a search of their own; for pixels of one cell.

    Where the UAV has ``been`` there is nothing to gain.
    """
    lens, steps = sensor(lidar), distance_field(belief, cell)
    places = [(int(r), int(c)) for r, c in np.argwhere(steps < 1000)]
    gains = {place: view_gain(belief, place, lidar) / lens.disc for place in places} | {been: 0.0}
    nearest = min((steps[place] * lens.rate for place, gain in gains.items() if gain > 0), default=None)
    found = [gains[cell] ** 0.5, 1.0 if nearest is None else nearest / (nearest + 8)]
    found += [max(gain * k ** steps[at] for at, gain in gains.items()) ** 0.5 for k in lens.decay]
    shares = [gain * lens.rate**2 * lens.decay[0] ** steps[at] for at, gain in gains.items()]
    return [*found, sum(shares) ** 0.5]


def test_the_move_features_are_what_they_say() -> None:
    belief, (row, col) = random_belief(np.random.default_rng(9))
    watcher = watched(belief, (row, col))
    watcher.memory.visits[:] = 2
    watcher.look(belief, (row, col))
    for k, features in enumerate(watcher.moves[0]):
        r, c = (np.array((row, col)) + MOVES[k]).tolist()
        if not (0 <= r < belief.shape[0] and 0 <= c < belief.shape[1] and belief[r, c] == FREE):
            assert features.tolist() == [1, 0, 1, 0, 0, 0, 0, 0]
            continue
        np.testing.assert_allclose(features, [0.0, *gains_behind(belief, (r, c), (row, col), 3.0), 0.5], rtol=1e-5)


@pytest.mark.parametrize("lidar", [1.0, 2.0, 3.0, 5.5])
def test_one_search_tells_what_lies_behind_every_move(lidar: float) -> None:
    rng, compared = np.random.default_rng(21), 0
    for _ in range(12):
        belief, cell = random_belief(rng)
        moves = watched(belief, cell, lidar=lidar).moves[0]
        for k in np.flatnonzero(moves[:, 0] == 0):
            r, c = (np.array(cell) + MOVES[k]).tolist()
            np.testing.assert_allclose(moves[k, 1:7], gains_behind(belief, (r, c), cell, lidar), rtol=1e-5)
            compared += 1
    assert compared > 20


@pytest.mark.parametrize("lidar", [3.0, 7.0])
def test_cached_values_equal_recomputed_ones(lidar: float) -> None:
    scenario = small_room(9).with_settings(
        {"map.height": 19, "map.width": 22, "team": 3, "lidar.range": lidar, "radio.model": "square", "radio.range": 4}
    )
    world, rng = World(scenario), np.random.default_rng(3)
    world.reset([4])
    sight = ObservationConfig(layers=("unknown", "free", "chance"), visits=False, tours=False, prospects=True)
    kept = [Watcher(sight, (19, 22), lidar) for _ in range(3)]
    heard = 0
    while world.flying.any():
        actions = np.full((1, 3), 4)
        for n in np.flatnonzero(world.flying[0]).tolist():
            view, fresh = world.view(0, n), Watcher(sight, (19, 22), lidar)
            heard += any(mate.age == 0 for mate in view.mates)
            fresh.memory.gain[kept[n].memory.gain == SPENT] = SPENT
            fresh.memory.prospect[:] = kept[n].memory.prospect
            for watcher in (kept[n], fresh):
                watcher.look(view.belief, view.cell)
            assert np.array_equal(kept[n].scene, fresh.scene)
            assert np.array_equal(kept[n].moves, fresh.moves)
            assert np.array_equal(kept[n].memory.chance, fresh.memory.chance)
            assert kept[n].memory.nearest[0] == fresh.memory.nearest[0]
            gains = kept[n].memory.gain[0]
            for row, col in rng.permutation(np.argwhere(gains >= 0))[:20].tolist():
                assert gains[row, col] == view_gain(view.belief, (row, col), lidar)
            actions[0, n] = rng.choice(np.flatnonzero(view.legal[:4]))
        world.step(actions)
    assert heard > 10


def test_changed_boxes_cover_all_newly_known_cells() -> None:
    rng = np.random.default_rng(6)
    belief, noted, boxes = np.zeros((9, 12), np.uint8), np.zeros((9, 12), np.uint8), np.zeros((5, 4), np.int64)
    for share in (0.02, 0.1, 0.0, 0.5, 1.0):
        belief[(rng.random(belief.shape) < share) & (belief == UNKNOWN)] = FREE
        changed, covered = (belief != UNKNOWN) & (noted == 0), np.zeros(belief.shape, np.bool_)
        count = note(belief, noted, boxes)
        for top, left, bottom, right in boxes[:count].tolist():
            assert changed[top:bottom, left:right].any(axis=1).all()
            assert changed[top:bottom, left].any()
            assert changed[top:bottom, right - 1].any()
            covered[top:bottom, left:right] = True
        assert not changed[~covered].any()
        assert np.array_equal(noted == 1, belief != UNKNOWN)


@pytest.mark.parametrize(("switched_off", "fewer"), [({"gains": False}, len(GAINS)), ({"visits": False}, len(VISITS))])
def test_disabled_features_are_left_out(switched_off: dict[str, bool], fewer: int) -> None:
    belief, cell = random_belief(np.random.default_rng(3))
    whole = watched(belief, cell).moves[0]
    config = EVERYTHING.model_copy(update=switched_off)
    names = ["blocked", *GAINS, *VISITS]
    kept = [names.index(name) for name in names if name not in (GAINS if "gains" in switched_off else VISITS)]
    part = watched(belief, cell, config).moves[0]
    assert part.shape[1] == whole.shape[1] - fewer
    assert np.array_equal(part, whole[:, kept])


def test_the_distance_to_the_nearest_gain_is_minus_one_without_any() -> None:
    belief = np.full((6, 7), FREE, np.uint8)
    assert watched(belief, (2, 3)).memory.nearest[0] == -1
    belief[5, 6] = UNKNOWN
    assert watched(belief, (5, 5)).memory.nearest[0] == 1  # what it does not see from where it is it never will


def test_visits_are_forgotten_after_a_gain_of_its_own() -> None:
    belief = np.zeros((4, 9), np.uint8)
    belief[:2, :3] = FREE
    watcher = Watcher(EVERYTHING, (4, 9))
    memory = watcher.memory
    for cell, gained, idle in (((0, 0), 6, 0), ((0, 1), 6, 1), ((0, 0), 6, 2)):
        watcher.look(belief, cell)
        assert (memory.gained[0], memory.idle[0]) == (gained, idle)
    assert memory.visits[0, 0, :2].tolist() == [2, 1]
    belief[0, 8] = FREE  # out of sight: heard by radio
    watcher.look(belief, (0, 1))
    assert memory.gained[0] == 6
    assert memory.visits[0, 0, :2].tolist() == [2, 2]
    belief[2, :3] = FREE
    watcher.look(belief, (1, 0))
    assert memory.gained[0] == 9
    assert memory.visits.sum() == memory.visits[0, 1, 0] == 1
    memory.forget([0])
    assert memory.visits.sum() == memory.gained[0] == 0


def test_a_way_that_a_teammate_was_in_is_blocked_for_longer_each_time() -> None:
    belief = np.full((4, 9), FREE, np.uint8)
    belief[:, 7:] = UNKNOWN
    watcher = Watcher(EVERYTHING, (4, 9))
    memory, here = watcher.memory, np.array([[1, 2]])
    east = int(np.flatnonzero((MOVES == (0, 1)).all(axis=1))[0])
    stays = []
    watcher.look(belief, (1, 2))
    for _ in range(3):
        memory.aim(here, np.array([east]))
        watcher.look(belief, (1, 2))  # pushed: it is still where it was
        memory.aim(here, np.array([4]))
        looks = 0
        while watcher.moves[0, east, 0] == 1:
            assert watcher.moves[0, :, 0].sum() == 1
            watcher.look(belief, (1, 2))
            looks += 1
        stays.append(looks)
    assert stays == [4, 8, 12]  # UAV 2 waits two looks longer than UAV 0
    memory.aim(here, np.array([east]))
    watcher.look(belief, (1, 3))  # got there
    assert not watcher.moves[0, :, 0].any()
    memory.aim(np.array([[0, 8]]), np.array([east]))
    assert memory.aimed.tolist() == [-1]  # off the map
    belief[:, 7] = FREE
    watcher.look(belief, (1, 6))
    assert memory.pushes[0] == 0  # forgotten after a gain


def test_a_layout_needs_a_middle_and_a_layer() -> None:
    with pytest.raises(ValueError, match="expected an odd number"):
        ObservationConfig(crop=14)
    with pytest.raises(ValueError, match="expected at least one layer"):
        ObservationConfig(layers=())
    assert ObservationConfig(layers=("free", "unknown")).layers == ("unknown", "free")
