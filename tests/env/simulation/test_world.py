"""Laws of the world, on random scenarios, maps and actions."""

import gc
import hashlib
import itertools
import math
import os
import subprocess
import sys
from fractions import Fraction

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_explorers.env import PRESETS, InputError, Scenario, World
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.lines import walls_between
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.sensing.lidar import scan
from indoor_explorers.env.simulation.radio import CELL_BYTES, POSITION_BYTES
from indoor_explorers.env.simulation.state import End
from tests.env.worlds import begun, floorplans, random_actions, scenarios
from tests.marks import slow

seeds = st.integers(0, 2**32)
examples = settings(max_examples=80, deadline=None)


def snapshot(world):
    return {name: array.copy() for name, array in world.state._asdict().items()}


def flight(world, seed, steps=25):
    """Yield (state before, actions, state after) of a random flight."""
    rng = np.random.default_rng(seed)
    for _ in range(steps):
        if not world.flying.any():
            return
        before = snapshot(world)
        actions = random_actions(rng, world)
        world.step(actions)
        yield before, actions[0], snapshot(world)


@examples
@given(scenarios(), floorplans(), seeds)
def test_beliefs_never_contradict_the_truth_and_never_shrink(scenario, floorplan, seed):
    world = begun(scenario, floorplan, seed)
    for before, _, after in flight(world, seed):
        known = after["belief"][0] != UNKNOWN
        assert (after["belief"][0][known] == np.broadcast_to(floorplan.truth, known.shape)[known]).all()
        assert (known | (before["belief"][0] == UNKNOWN)).all()
        stopped = after["end"][0] == End.STOPPED
        assert (after["team_covered"] >= before["team_covered"]).all() or (stopped & (before["end"][0] == 0)).any()
        held = known[~stopped].any(axis=0)
        if scenario.base.exists:
            held |= after["base_belief"][0] != UNKNOWN
        assert ((after["union"][0] != UNKNOWN) == held).all()


@examples
@given(scenarios(), floorplans(), seeds)
def test_counts_equal_recounts(scenario, floorplan, seed):
    world = begun(scenario, floorplan, seed)
    been = {(n, *cell) for n, cell in enumerate(world.state.cell[0].tolist())}
    for _, _, after in flight(world, seed):
        counts = after["counts"][0]
        assert after["covered"][0].tolist() == [int((b[counts] != UNKNOWN).sum()) for b in after["belief"][0]]
        assert after["team_covered"][0] == (after["union"][0][counts] != UNKNOWN).sum()
        been |= {(n, *cell) for n, cell in enumerate(after["cell"][0].tolist())}
        assert {tuple(place) for place in np.argwhere(after["visited"][0]).tolist()} == been
        assert after["sensed_count"][0].tolist() == [int(seen[counts].sum()) for seen in after["sensed"][0]]
        assert after["known"][0].tolist() == [int((b != UNKNOWN).sum()) for b in after["belief"][0]]


@examples
@given(scenarios(), floorplans(), seeds)
def test_nobody_enters_a_wall_or_a_mate_and_moves_are_one_cell(scenario, floorplan, seed):
    world = begun(scenario, floorplan, seed)
    for before, actions, after in flight(world, seed):
        cells = after["cell"][0]
        assert (floorplan.truth[cells[:, 0], cells[:, 1]] == FREE).all()
        flying = before["end"][0] == End.FLYING
        airborne = cells[flying & ~np.isin(after["end"][0], [End.COLLISION, End.OUT_OF_BOUNDS])]
        assert len({tuple(cell) for cell in airborne.tolist()}) == len(airborne)
        moved = np.abs(cells - before["cell"][0]).sum(axis=1)
        assert (moved <= (flying & (actions != 4))).all()


@examples
@given(scenarios(), floorplans(), seeds)
def test_knowledge_is_own_scans_and_the_union_within_each_radio_component(scenario, floorplan, seed):
    """The whole of sensing and merging, the home base's too, against sets and networkx."""
    world = begun(scenario, floorplan, seed)
    truth, known = floorplan.truth, [set() for _ in range(scenario.team)]
    fading = world.state.fading[0].tolist()
    reported, base = set(), tuple(world.state.base_cell[0].tolist())

    def sense_and_merge(state, flew):
        cells = [tuple(cell) for cell in state["cell"][0].tolist()]
        for n in np.flatnonzero(flew):
            belief = scan(floorplan.truth, cells[n], scenario.lidar.range, scenario.lidar.model)
            known[n] |= set(np.flatnonzero(belief != UNKNOWN).tolist())
        crashed = np.isin(state["end"][0], [End.COLLISION, End.OUT_OF_BOUNDS])
        silent = state["step"][0] < state["silent_until"][0]
        stopped = (state["end"][0] == End.STOPPED) & (not scenario.failures.last_word)
        graph = nx.Graph()
        graph.add_nodes_from(np.flatnonzero(flew & ~crashed & ~stopped).tolist())
        heard = [n for n in graph if not silent[n]]
        reach = [
            (i, j) for i in heard for j in heard if i < j and linked(scenario.radio, truth, cells[i], cells[j], fading)
        ]
        links = [(i, j) for i, j in reach if state["linked"][0, i, j]]  # some may be lost
        assert len(links) * 2 == state["linked"].sum()
        assert links == reach or scenario.radio.loss > 0
        graph.add_edges_from(links)
        if scenario.base.exists:
            link_base(state, graph, cells, silent)
        for component in nx.connected_components(graph):
            together = set.union(*(reported if n == "base" else known[n] for n in component))
            for n in component - {"base"}:
                known[n] = set(together)
            if "base" in component:
                reported.update(together)
        if scenario.base.exists:
            assert set(np.flatnonzero(state["base_belief"][0] != UNKNOWN).tolist()) == reported
            counted = np.flatnonzero(state["counts"][0])
            assert state["base_covered"][0] == len(reported & set(counted.tolist()))
        for n, belief in enumerate(state["belief"][0]):
            assert set(np.flatnonzero(belief != UNKNOWN).tolist()) == known[n]

    def link_base(state, graph, cells, silent):
        """Add the base and its contacts; with losses, those that the world says."""
        near = {n for n in graph if np.hypot(*np.subtract(cells[n], base)) <= scenario.base.radius}
        radio = {n for n in graph if not silent[n] and linked(scenario.radio, truth, cells[n], base, fading)}
        found = set(np.flatnonzero(state["base_contact"][0]).tolist())
        graph.add_edges_from(("base", n) for n in near | radio)
        expected = nx.node_connected_component(graph, "base") - {"base"} if near | radio else set()
        if scenario.radio.loss > 0:
            graph.remove_edges_from([("base", n) for n in graph if n != "base" and n not in found])
        assert found == expected or (scenario.radio.loss > 0 and found <= expected)
        assert near <= found

    sense_and_merge(snapshot(world), np.ones(scenario.team, bool))
    for before, _, after in flight(world, seed):
        sense_and_merge(after, before["end"][0] == End.FLYING)


def linked(radio, truth, a, b, fading):
    """The radio models, told apart by the distance and, for three of them, what is between two cells."""
    rows, cols = abs(a[0] - b[0]), abs(a[1] - b[1])
    distance = float(np.hypot(rows, cols))
    return {
        "none": lambda: False,
        "square": lambda: max(rows, cols) <= radio.range,
        "disc": lambda: distance <= radio.range,
        "line-of-sight": lambda: distance <= radio.range and scan(truth, a, distance + 1)[b] == FREE,
        "path-loss": lambda: (
            distance <= radio.range * 10 ** (-walls(truth, a, b) * radio.wall_loss / (10 * radio.exponent)) + 1e-9
        ),
        "path-loss-ir2": lambda: min(ir2_loss(radio, truth, *ends, *fading) for ends in ((a, b), (b, a))) < 50,
        "unlimited": lambda: True,
    }[radio.model]()


def ir2_loss(radio, truth, a, b, k, x):
    """The loss in dB that IR2's code finds from cell a to cell b, whose pixels are 35 to ``radio.range``."""
    pixel = 35 / max(radio.range, 1e-9)
    steps = max(abs(b[0] - a[0]), abs(b[1] - a[1]))
    shares = [Fraction(step, steps) for step in range(1, steps + 1)]
    line = [
        tuple(
            p + math.copysign(math.floor(abs(q - p) * share + Fraction(1, 2)), q - p) for p, q in zip(a, b, strict=True)
        )
        for share in shares
    ]
    wall = pixel * sum(truth[int(row), int(col)] == OCCUPIED for row, col in line)
    free = pixel * math.dist(a, b) - wall
    return 31 + (40 * math.log10(wall) + k if wall else 0) + (20 * math.log10(free / 35) + x if free >= 35 else 0)


def walls(truth, a, b):
    """Runs of obstacles among the cells that a segment crosses, by cutting it at every cell border exactly."""
    (y, x), (dy, dx) = a, (b[0] - a[0], b[1] - a[1])
    borders = {Fraction(2 * k + 1, 2 * abs(d)) for d in (dy, dx) if d for k in range(abs(d))}
    cuts = sorted(borders | {Fraction(0), Fraction(1)})
    half, inside, count = Fraction(1, 2), False, 0
    for start, stop in itertools.pairwise(cuts):
        middle = (start + stop) / 2
        solid = truth[math.floor(y + middle * dy + half), math.floor(x + middle * dx + half)] == OCCUPIED
        row, col = y + start * dy + half, x + start * dx + half
        if not inside and not solid and start and row.denominator == col.denominator == 1:
            corner = truth[int(row) - 1 : int(row) + 1, int(col) - 1 : int(col) + 1] == OCCUPIED
            count += bool((corner[0, 0] and corner[1, 1]) or (corner[0, 1] and corner[1, 0]))
        count += bool(solid and not inside)
        inside = solid
    return count


@settings(max_examples=200, deadline=None)
@given(floorplans(), st.integers(0, 2**32))
def test_walls_between_two_cells_are_counted_exactly_and_alike_from_both_ends(floorplan, seed):
    free = np.argwhere(floorplan.truth == FREE)
    rng = np.random.default_rng(seed)
    for a, b in free[rng.integers(len(free), size=(20, 2))].tolist():
        found = walls_between(floorplan.truth, *a, *b)
        assert found == walls_between(floorplan.truth, *b, *a) == (walls(floorplan.truth, a, b) if a != b else 0)


def test_contacts_are_lost_with_their_probability():
    scenario = Scenario(team=2, spawn=((0, 0), (0, 1)), radio={"model": "disc", "range": 2.0, "loss": 0.3}, budget=2000)
    world = begun(scenario, Floorplan(np.ones((1, 3), np.uint8), "corridor"), 3)
    world.state.needed[:] = 99  # nobody is done
    held = []
    for _ in range(2000):
        world.step(np.full((1, 2), 4))
        held.append(bool(world.state.linked[0, 0, 1]))
    assert 0.66 < np.mean(held) < 0.74
    assert 0.55 < np.mean(np.array(held[1:])[np.array(held[:-1])]) < 0.8  # each step is drawn anew


@examples
@given(scenarios(), floorplans(), seeds)
def test_rewards_add_up(scenario, floorplan, seed):
    world = begun(scenario, floorplan, seed)
    pay = scenario.rewards
    for before, _, after in flight(world, seed):
        for n in range(scenario.team):
            if before["end"][0, n] != End.FLYING:
                assert after["reward"][0, n] == 0
                continue
            crashes = int(after["collisions"][0, n] - before["collisions"][0, n])
            ended = after["end"][0, n]
            expected = pay.step + crashes * pay.collision
            if ended not in (End.COLLISION, End.OUT_OF_BOUNDS, End.STOPPED):
                expected += pay.discovered * after["discovered"][0, n] + pay.received * after["received"][0, n]
            ends = {End.GOAL: pay.goal, End.STUCK: pay.stuck, End.STOPPED: scenario.failures.reward}
            expected += ends.get(End(int(ended)), 0.0)
            assert after["reward"][0, n] == pytest.approx(expected)


@examples
@given(scenarios(), floorplans(), seeds)
def test_own_and_received_discoveries_are_kept_apart(scenario, floorplan, seed):
    world = begun(scenario, floorplan, seed)
    for before, _, after in flight(world, seed):
        grown = after["known"][0] - before["known"][0]
        assert (grown == after["discovered"][0] + after["received"][0]).all()
        if (scenario.radio.model == "none" or scenario.team == 1) and not scenario.base.exists:
            assert not after["received"].any()
            assert not after["sent_bytes"].any()


@examples
@given(scenarios(), floorplans(), seeds)
def test_an_ended_agent_stays_ended_and_every_end_has_its_cause(scenario, floorplan, seed):
    world = begun(scenario, floorplan, seed)
    for before, _, after in flight(world, seed, steps=70):
        was, now = before["end"][0], after["end"][0]
        assert (now[was != End.FLYING] == was[was != End.FLYING]).all()
        covered = after["team_covered"][0] if scenario.goal_of == "team" else after["covered"][0]
        if scenario.goal_of == "every" and (was == End.FLYING).any():
            stayed = (was == End.FLYING) & ~np.isin(now, [End.COLLISION, End.OUT_OF_BOUNDS, End.STOPPED])
            covered = covered[stayed].min(initial=10**9)
        covered = after["base_covered"][0] if scenario.base.must_return else covered
        reached = np.broadcast_to(covered >= after["needed"][0], now.shape)
        fresh = was == End.FLYING
        assert (reached[fresh & (now == End.GOAL)]).all()
        assert not (reached & fresh & np.isin(now, [End.FLYING, End.BUDGET, End.STUCK])).any()
        if after["step"][0] >= scenario.budget:
            assert (now != End.FLYING).all()
        assert ((now == End.BUDGET) & fresh).any() <= (after["step"][0] >= scenario.budget)
        assert not (now == End.STOPPED).any() or scenario.failures.hazard


def test_same_seed_same_episode_in_any_batch():
    scenario = PRESETS["thesis-team-4"]
    rng = np.random.default_rng(5)
    actions = rng.integers(0, 5, (40, 6, 4))
    together = World(scenario.with_settings({"on_collision": "block"}), 6)
    together.reset(range(6))
    alone = [World(together.scenario) for _ in range(6)]
    for b, world in enumerate(alone):
        world.reset([b])
    for step in actions:
        together.step(step)
        for b, world in enumerate(alone):
            world.step(step[b : b + 1])
    for b, world in enumerate(alone):
        for name, array in world.state._asdict().items():
            np.testing.assert_array_equal(array[0], getattr(together.state, name)[b], err_msg=name)


def test_same_episodes_with_any_number_of_threads():
    worlds = [World(PRESETS["thesis-team-4"], 7, threads=threads) for threads in (1, 2, 3, 20)]
    rng = np.random.default_rng(6)
    for world in worlds:
        world.reset(range(7))
    for _ in range(60):
        actions = rng.integers(0, 5, (7, 4))
        for world in worlds:
            world.step(actions)
    for world in worlds[1:]:
        for name, array in world.state._asdict().items():
            np.testing.assert_array_equal(array, getattr(worlds[0].state, name), err_msg=name)


@pytest.mark.parametrize("number", [1, *slow(0)])
def test_same_episodes_in_another_process(number):
    """Another process, with another hash seed and thread count, flies the same episode."""
    code = (
        "import hashlib, numpy as np; from indoor_explorers.env import PRESETS, World;"
        "world = World(PRESETS['thesis-team-4'], 2); world.reset([11, 12]);"
        "rng = np.random.default_rng(1);"
        "[world.step(rng.integers(0, 5, (2, 4))) for _ in range(50)];"
        "print(hashlib.sha256(b''.join(array.tobytes() for array in world.state)).hexdigest())"
    )
    other = subprocess.run(
        [sys.executable, "-P", "-c", code],
        env=os.environ | {"PYTHONHASHSEED": str(number), "NUMBA_NUM_THREADS": str(number + 1)},
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    world = World(PRESETS["thesis-team-4"], 2)
    world.reset([11, 12])
    rng = np.random.default_rng(1)
    for _ in range(50):
        world.step(rng.integers(0, 5, (2, 4)))
    here = hashlib.sha256(b"".join(array.tobytes() for array in world.state)).hexdigest()
    assert other == here + "\n"


def test_a_map_of_2048_x_2048_cells():
    truth = np.ones((2048, 2048), np.uint8)
    truth[::50, ::3] = OCCUPIED
    scenario = Scenario(team=2, spawn="clustered", lidar={"range": 20.0}, radio={"model": "disc", "range": 9.0})
    world = begun(scenario, Floorplan(truth, "huge"), 1)
    before = world.state.team_covered[0]
    for _ in range(20):
        world.step(np.full((1, 2), 3))
    assert world.state.team_covered[0] > before
    assert world.state.total[0] == (truth == FREE).sum()


def test_a_team_of_64_knows_what_the_whole_of_it_knows():
    room = {"source": "thesis", "height": 40, "width": 50, "obstacles": 20}
    world = World(Scenario(map=room, team=64, spawn="clustered", radio={"model": "unlimited"}, on_collision="block"))
    world.reset([3])
    rng = np.random.default_rng(4)
    for _ in range(30):
        world.step(rng.integers(0, 5, (1, 64)))
        assert (world.state.belief[0] == world.state.union[0]).all()
        assert len(np.unique(world.state.cell[0], axis=0)) == 64
    assert len(world.view(0, 5).mates) == 63


def test_what_pilots_draw_changes_nothing_else():
    """Map, spawns, order of moves and the other pilots' draws are the same however much one pilot draws."""
    frugal, greedy = (World(PRESETS["thesis-team-4"]) for _ in range(2))
    for world in (frugal, greedy):
        world.reset([8])
    greedy.briefing(0, 0).rng.random(1000)
    np.random.default_rng(0).random(1000)
    for action in (0, 1, 2, 3) * 5:
        for world in (frugal, greedy):
            world.step(np.full((1, 4), action))
        greedy.briefing(0, 1).rng.random()
    assert (frugal.state.truth == greedy.state.truth).all()
    assert (frugal.state.cell == greedy.state.cell).all()
    assert frugal.briefing(0, 2).rng.random() == greedy.briefing(0, 2).rng.random()
    draws = {world.briefing(0, n).rng.random() for world in (frugal, greedy) for n in range(4)}
    assert len(draws) == 4


def test_the_order_of_moves_is_random_and_fair():
    """Two UAVs want the same cell: each gets it about half of the time."""
    truth = np.full((1, 3), FREE)
    scenario = Scenario(team=2, spawn=((0, 0), (0, 2)), on_collision="block", budget=5, lidar={"range": 1.0})
    first = 0
    for seed in range(400):
        world = begun(scenario, Floorplan(truth.astype(np.uint8), "corridor"), seed)
        world.step(np.array([[3, 1]]))
        first += tuple(world.state.cell[0, 0]) == (0, 1)
        assert world.state.blocked[0].sum() == 1
    assert 150 < first < 250


def test_square_radio_reaches_its_range_and_not_twice_it():
    truth = np.full((1, 12), FREE)
    for distance, together in ((3, True), (4, False), (6, False)):
        scenario = Scenario(team=2, spawn=((0, 0), (0, distance)), radio={"model": "square", "range": 3.0}, budget=9)
        world = begun(scenario, Floorplan(truth.astype(np.uint8), "corridor"), 0)
        assert bool(world.state.linked[0, 0, 1]) is together


def test_a_message_arrives_and_ages():
    truth = np.full((1, 30), FREE).astype(np.uint8)
    scenario = Scenario(team=2, spawn=((0, 3), (0, 4)), radio={"model": "square", "range": 2.0}, budget=20)
    world = begun(scenario, Floorplan(truth, "corridor"), 0)
    assert world.view(0, 0).mates == ((1, (0, 4), 0, None),)
    world.post(0, 1, (7.0, -1.5))
    for _ in range(4):
        world.step(np.array([[4, 3]]))
    mate = world.view(0, 0).mates[0]
    assert (mate.cell, mate.age, mate.message) == ((0, 5), 3, (7.0, -1.5))
    assert world.view(0, 1).mates[0].age == 3


def test_bytes_are_changed_cells_positions_and_numbers():
    truth = np.full((1, 20), FREE).astype(np.uint8)
    scenario = Scenario(team=2, spawn=((0, 0), (0, 9)), radio={"model": "disc", "range": 8.0}, budget=20)
    world = begun(scenario, Floorplan(truth, "corridor"), 0)
    assert not world.state.sent_bytes.any()
    world.post(0, 0, (1.0, 2.0))
    world.step(np.array([[3, 4]]))
    first = 5 * CELL_BYTES + POSITION_BYTES + 2 * 8
    second = 7 * CELL_BYTES + POSITION_BYTES
    assert world.state.sent_bytes[0].tolist() == [first, second]
    world.step(np.array([[4, 4]]))
    assert world.state.sent_bytes[0].tolist() == [first + POSITION_BYTES + 16, second + POSITION_BYTES]


def test_stuck_rules_end_at_their_numbers():
    truth = np.full((2, 2), FREE).astype(np.uint8)
    for stuck, expected in (
        ({"rule": "oscillation", "window": 50, "repeats": 20}, 20),
        ({"rule": "oscillation", "window": 50, "repeats": 10}, 10),
        ({"rule": "no-discovery"}, 4),
    ):
        scenario = Scenario(stuck=stuck, budget=100, denominator="map", goal=1.0, lidar={"range": 1.0})
        world = World(scenario)
        world.begin(0, 0, floorplan=Floorplan(truth, "room"), spawns=[(0, 0)])
        steps = 0
        while world.flying.any():
            world.step(np.array([[4]]))
            steps += 1
        assert steps == expected
        assert world.state.end[0, 0] == End.STUCK


def test_denominators():
    truth = np.array([[1, 1, 2, 1], [1, 1, 2, 1]], np.uint8)
    for denominator, total in (("reachable", 4), ("map", 8)):
        scenario = Scenario(denominator=denominator, budget=5, spawn=((0, 0),), goal=0.5)
        assert begun(scenario, Floorplan(truth, "split"), 0).state.total[0] == total
    everywhere = Scenario(team=2, budget=5, spawn=((0, 0), (1, 3)), goal=0.5)
    assert begun(everywhere, Floorplan(truth, "split"), 0).state.total[0] == 6


def test_a_goal_that_can_never_be_reached_is_refused():
    scenario = Scenario(map={"source": "thesis", "obstacles": 400}, denominator="map", goal=0.95)
    with pytest.raises(InputError, match=r"can never be seen .* lower goal"):
        World(scenario).reset([0])


def test_spawns_are_free_connected_and_distinct():
    for spawn in ("random", "clustered"):
        world = World(PRESETS["thesis-team-4"].with_settings({"spawn": spawn, "team": 64}), 3)
        world.reset([1, 2, 3])
        for b in range(3):
            cells = {tuple(cell) for cell in world.state.cell[b].tolist()}
            assert len(cells) == 64
            assert all(world.floorplan(b).main_part[cell] for cell in cells)


def test_actions_of_a_wrong_shape_are_refused():
    world = World(PRESETS["thesis-open"])
    world.reset([0])
    with pytest.raises(InputError, match=r"expected actions of shape \(1, 1\)"):
        world.step(np.array([[0, 1]]))


@pytest.mark.parametrize("spawns", [[(0, 0), (0, 9)], [(0, 0), (-1, 0)], [(0, 0), (1, 1)], [(0, 0), (0, 0)]])
def test_given_spawns_are_free_and_distinct_cells(spawns):
    plan = Floorplan(np.array([[1, 1], [1, 2]], np.uint8), "corner")
    with pytest.raises(InputError, match=r"is no free cell|cannot spawn in the same cell"):
        World(Scenario(team=2)).begin(0, 0, floorplan=plan, spawns=spawns)


def test_a_view_is_live_and_outlives_its_world():
    world = World(PRESETS["thesis-open"])
    world.reset([0])
    belief = world.view(0, 0).belief
    before = belief.copy()
    for action in (0, 1, 2, 3) * 3:
        world.step([[action]])
    np.testing.assert_array_equal(belief, world.state.belief[0, 0])
    assert (belief != before).any()
    last = belief.copy()
    del world
    gc.collect()
    np.testing.assert_array_equal(belief, last)


def test_only_privileged_briefings_tell_the_map_and_the_starts():
    world = World(PRESETS["thesis-team-2"])
    world.reset([3])
    plain, privileged = world.briefing(0, 1), world.briefing(0, 1, privileged=True)
    assert plain.truth is None
    assert plain.starts is None
    np.testing.assert_array_equal(privileged.truth, world.state.truth[0])
    assert privileged.starts == tuple(world.view(0, agent).cell for agent in (0, 1))
    assert "starts" not in repr(privileged)


def test_views_are_read_only():
    world = World(PRESETS["thesis-open"])
    world.reset([0])
    view = world.view(0, 0)
    for array in (view.belief, view.legal, view.visited, world.briefing(0, 0, privileged=True).truth):
        for part in (array, array[:2], array.view()):
            with pytest.raises(ValueError, match="cannot set WRITEABLE flag to True"):
                part.setflags(write=True)
            assert not isinstance(part.base, np.ndarray) or not part.base.flags.writeable
    with pytest.raises(ValueError, match="read-only"):
        view.belief[0, 0] = OCCUPIED
    with pytest.raises(ValueError, match="read-only"):
        view.legal[0] = True
