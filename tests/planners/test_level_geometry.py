"""Distances of planners on maps of several levels: in the volume, not in the plane that it lies in."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from math import exp

import numpy as np
import pytest

from indoor_explorers.env import Mate, World, make_policy, scenario
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN, Action
from indoor_explorers.env.grid.levels import Levels, coordinates, plane_of
from indoor_explorers.env.policies.view import View
from indoor_explorers.env.sensing.lidar import lidar_model
from indoor_explorers.planners.frontier.burgard import nearness
from indoor_explorers.planners.frontier.joint import JointPilot
from indoor_explorers.planners.frontier.mrtsp import FrontierMrtsp, MrtspPilot
from indoor_explorers.planners.frontier.tour import FrontierTour, TourPilot
from indoor_explorers.planners.sampling.cover_tour import CoverTour, CoverTourPilot
from indoor_explorers.planners.swarm.aco import Pheromone
from indoor_explorers.planners.swarm.gso import GlowwormPilot, Gso
from indoor_explorers.planners.swarm.hedac import climb, heat_up, sweep
from indoor_explorers.planners.toolbox.coordination.out_of_contact import OutOfContact, Sectors
from indoor_explorers.planners.toolbox.frontiers.clusters import Clusters, middles
from indoor_explorers.planners.toolbox.information.candidates import UnknownWeight, cell_weight
from indoor_explorers.planners.toolbox.information.view_gain import WeightedGains, unclaimed_gains
from indoor_explorers.planners.toolbox.navigation.map_sharing import MapSharing, SilentMate
from indoor_explorers.planners.toolbox.navigation.paths import Paths, near_any
from indoor_explorers.planners.toolbox.navigation.teammates import remembered, should_be_linked
from tests.planners.flights import view_of

WORLD = World(scenario("small-storeys").with_settings({"team": 2, "radio.model": "disc", "radio.range": 5.0}))
WORLD.reset([3])
BRIEFING = WORLD.briefing(0, 0)
LEVELS = BRIEFING.levels
SMALL = Levels(4, 6, 5)
ALL_SMALL = list(product(*map(range, tuple(SMALL))))


def flat(levels: Levels, *voxels: tuple[int, int, int]) -> np.ndarray:
    """The flat cells of the plane of some voxels, (K,) int32."""
    return np.array([row * levels.width + col for row, col in map(levels.cell, voxels)], np.int32)


def explored(steps: int) -> View:
    """What a UAV knows after some steps of the nearest frontier."""
    world = World(scenario("small-storeys").with_settings({"team": 1}))
    world.reset([3])
    pilot = make_policy("frontier-nearest").pilot(world.briefing(0, 0))
    for _ in range(steps):
        world.step([[pilot.act(world.view(0, 0))]])
    view = world.view(0, 0)
    return view._replace(belief=view.belief.copy(), visited=view.visited.copy())


def test_goals_are_near_in_the_volume():
    pilot, goal = GlowwormPilot(BRIEFING, Gso()), LEVELS.cell((2, 4, 4))
    cells = flat(LEVELS, (4, 4, 4), (2, 6, 4), (3, 5, 5), (2, 4, 7), (1, 23, 4))
    assert pilot.near_goal(goal, cells, 2.0).tolist() == [True, True, True, False, False]
    assert pilot.near_goal(goal, cells, 1.0, np.maximum).tolist() == [False, False, True, False, False]
    top = LEVELS.cell((2, 0, 4))  # two rows below the last one of the level before, in the plane
    assert not pilot.near_goal(top, flat(LEVELS, (1, 23, 4)), 2.0).any()


def test_goals_near_a_banned_one_are_those_of_its_cube():
    cells = flat(LEVELS, (2, 0, 4), (4, 2, 6), (5, 0, 4), (1, 23, 4))
    assert near_any(cells, flat(LEVELS, (2, 0, 4)), LEVELS.width, LEVELS.rise).tolist() == [True, True, False, False]


@pytest.mark.parametrize(
    ("voxel", "model", "linked"),
    [((5, 4, 4), "disc", True), ((1, 4, 4), "disc", False), ((4, 8, 7), "square", True), ((0, 4, 4), "square", False)],
)
def test_who_should_be_linked_is_near_in_the_volume(voxel, model, linked):
    radio = BRIEFING.scenario.radio.model_copy(update={"model": model})
    mate = Mate(1, LEVELS.cell(voxel), 1, None)
    assert should_be_linked(radio, LEVELS.cell((6, 4, 4)), mate, LEVELS.rise) is linked
    if model == "disc":
        view = view_of(np.full(LEVELS.shape, FREE, np.uint8), LEVELS.cell((6, 4, 4)), (mate,))
        assert bool(remembered(view, BRIEFING)) is not linked


def test_sectors_are_the_same_on_every_level():
    start, briefing = LEVELS.cell((5, 12, 12)), replace(BRIEFING, team=4)
    left = OutOfContact(briefing, sector=2.0)
    view = view_of(np.full(LEVELS.shape, FREE, np.uint8), start)
    places = [(row, col) for row in (2, 12, 21) for col in (3, 20)]
    factors = [left.left_by_unheard_at_cells(view, flat(LEVELS, *((k, *at) for at in places))) for k in range(7)]
    plain = Sectors((24, 24), (12.0, 12.0), 4).shares(np.array(places, np.float64), 0, 2.0)
    np.testing.assert_allclose(factors, [plain] * 7)


def test_a_goal_passes_to_the_cluster_above_and_not_to_the_one_beside_it_in_the_plane():
    pilot = JointPilot(BRIEFING, make_policy("frontier"))
    assert pilot.hysteresis_bonus(LEVELS.cell((2, 0, 4)), flat(LEVELS, (3, 0, 4), (1, 23, 4)), 0.5).tolist() == [1.5, 1]
    group = TourPilot(BRIEFING, FrontierTour())
    clusters = Clusters(flat(LEVELS, (1, 23, 4), (4, 0, 4)), np.array([0, 1, 2]))
    assert group._held(clusters, LEVELS.cell((2, 0, 4))).tolist() == [False, True]


def test_tours_lead_through_the_middles_of_clusters_in_the_volume():
    view = explored(30)
    cover, tour = CoverTourPilot(BRIEFING, CoverTour()), TourPilot(BRIEFING, FrontierTour())
    clusters = tour.clusters(view)
    wanted = middles(clusters, LEVELS.width, LEVELS.rise)
    assert len(np.setdiff1d(wanted, middles(clusters, LEVELS.width)))
    assert np.isin(wanted, cover._candidates(view)).all()
    tour.act(view)
    numbers = tour.choices(view, tour.members(view)).numbers
    assert set(tour._between._places.tolist()) == set(wanted[numbers[: len(tour._between._places)]].tolist())


def test_spread_and_turns_of_the_minimum_ratio_tour_are_those_of_the_volume():
    pilot, belief = MrtspPilot(BRIEFING, FrontierMrtsp()), np.full(LEVELS.shape, OCCUPIED, np.uint8)
    for voxel, value in {
        (2, 4, 4): FREE,
        (3, 4, 4): FREE,
        (4, 4, 4): UNKNOWN,
        (2, 4, 5): FREE,
        (2, 4, 6): UNKNOWN,
    }.items():
        belief[LEVELS.cell(voxel)] = value
    view = view_of(belief, LEVELS.cell((2, 4, 4)))._replace(legal=np.ones(7, np.bool_))
    choices = pilot.choices(view, pilot.members(view))
    pilot.gains(view, choices)
    assert pilot._spread.max() <= 2.0 - BRIEFING.lidar_range
    pilot._before = LEVELS.cell((1, 4, 4))
    turns = pilot._quarter_turns(view.cell, np.array([[3.0, 4.0, 4.0], [2.0, 4.0, 9.0], [0.0, 4.0, 4.0]]))
    assert turns == pytest.approx([0.0, 1.0, 2.0])


def test_taken_clusters_lower_the_value_of_those_above_them_that_they_see():
    volume = np.full(tuple(SMALL), FREE, np.uint8)
    volume[1, :, 4] = OCCUPIED
    cells = flat(SMALL, (0, 2, 1), (1, 2, 1), (2, 2, 1), (2, 2, 4), (1, 5, 1))
    reach = lidar_model(3.0, "exact", SMALL.number)
    near = nearness(plane_of(volume), int(cells[0]), cells, reach, SMALL.rise)
    assert near == pytest.approx([1.0, 2 / 3, 1 / 3, 0.0, 0.0])
    volume[1] = OCCUPIED
    near = nearness(plane_of(volume), int(cells[0]), cells, reach, SMALL.rise)
    assert near == pytest.approx([1.0, 2 / 3, 0.0, 0.0, 0.0])  # the obstacle itself is seen


def test_cells_near_claims_are_those_in_range_above_and_below():
    volume = np.full(tuple(SMALL), UNKNOWN, np.uint8)
    volume[1, 2, 2] = FREE
    origin, reach = flat(SMALL, (1, 2, 2)), lidar_model(2.0, "exact", SMALL.number)
    seen = unclaimed_gains(plane_of(volume), origin, np.empty((0, 2)), reach)[0]
    above = np.array([SMALL.cell((2, 2, 2))], np.float64)
    voxels = np.array(ALL_SMALL)
    away = [np.hypot.reduce(voxels - np.array(at), axis=1) for at in ((1, 2, 2), (2, 2, 2))]
    both = int(((away[0] <= 2.0) & (away[0] > 0) & (away[1] <= 2.0)).sum())
    assert unclaimed_gains(plane_of(volume), origin, above, reach)[0] == seen - both


def test_isolation_counts_the_cells_of_the_cube():
    rng = np.random.default_rng(4)
    volume = rng.choice([UNKNOWN, FREE], tuple(SMALL)).astype(np.uint8)
    unknown = np.pad(volume == UNKNOWN, 2)
    for level, row, col in ALL_SMALL:
        closed = 125 - unknown[level : level + 5, row : row + 5, col : col + 5].sum()
        cell, depth = int(flat(SMALL, (level, row, col))[0]), np.zeros(SMALL.shape, np.int32)
        weight = cell_weight(plane_of(volume), depth, cell, UnknownWeight(8.0, 1.0), SMALL.rise)
        assert weight == pytest.approx(1.0 + 8.0 * closed / 124)


def test_kept_gains_over_levels_are_those_of_the_map_as_it_is():
    rng, reach = np.random.default_rng(5), lidar_model(2.0, "exact", 9)
    levels = Levels(9, 8, 9)
    truth = plane_of(np.where(rng.random(tuple(levels)) < 0.2, OCCUPIED, FREE).astype(np.uint8))
    belief = np.where(levels.between, OCCUPIED, UNKNOWN).astype(np.uint8)
    kept = WeightedGains(belief.shape, reach, 0.5, 8.0)
    for _ in range(60):
        at = levels.cell((int(rng.integers(9)), int(rng.integers(8)), int(rng.integers(9))))
        belief[at] = truth[at]
        cells = np.flatnonzero(belief == FREE).astype(np.int32)
        assert (
            kept.at(belief, cells).tolist() == WeightedGains(belief.shape, reach, 0.5, 8.0).at(belief, cells).tolist()
        )


def test_glowworms_above_are_the_same_and_dim_those_below():
    pilot = GlowwormPilot(BRIEFING, Gso())
    pilot._cells, pilot._luciferin = flat(LEVELS, (2, 0, 4)), np.array([7.0])
    cells = flat(LEVELS, (3, 0, 4), (1, 23, 4))
    assert pilot._before(cells, np.zeros(2)).tolist() == [7.0, 0.0]
    row, col = LEVELS.cell((2, 0, 4))
    view = view_of(np.full(LEVELS.shape, FREE, np.uint8), (0, 0), (Mate(1, (0, 0), 0, (float(row), float(col))),))
    assert pilot.not_dimmed(view, cells, 0.5).tolist() == [0.5, 1.0]


@pytest.mark.parametrize("voxel", [(0, 0, 0), (3, 5, 4), (1, 2, 3)])
def test_pheromone_falls_with_the_distance_in_the_volume(voxel):
    pheromone = Pheromone(SMALL, 2.5, 2.0)
    pheromone.lay(SMALL.cell(voxel), 3.0)
    away = np.hypot.reduce(np.array(ALL_SMALL) - np.array(voxel), axis=1)
    expected = np.where(away <= 2.5, 3.0 * np.exp(-away / 2.0), 0.0).reshape(tuple(SMALL))
    np.testing.assert_allclose(SMALL.volume(pheromone.field), expected)
    assert not pheromone.field[SMALL.between].any()
    assert pheromone.field[SMALL.cell(voxel)] == pytest.approx(3.0 * exp(0.0))


def test_heat_rises_through_an_opening_and_is_cooled_on_both_sides_of_it():
    volume = np.full(tuple(SMALL), FREE, np.uint8)
    volume[1], volume[1, 3, 2], volume[3, 5] = OCCUPIED, FREE, UNKNOWN
    belief, heat = plane_of(volume, between=OCCUPIED), np.empty(SMALL.shape)
    nobody = np.empty((0, 2))
    heat_up(belief, nobody, 3.0, 0.25, nobody.astype(np.int64), heat, SMALL.rise)
    field = np.zeros(SMALL.shape)
    for _ in range(60):
        sweep(field, belief, heat, 1.0, SMALL.rise)
    end = climb(field, belief, *SMALL.cell((0, 0, 0)), SMALL.rise)
    assert coordinates(np.array(end), SMALL.width, SMALL.rise)[:2].tolist() in ([3, 4], [2, 5])
    heat_up(belief, np.array([SMALL.cell((2, 5, 2))], np.float64), 1.0, 0.25, nobody.astype(np.int64), heat, SMALL.rise)
    assert heat[SMALL.cell((3, 5, 2))] == 0.25
    assert heat[SMALL.cell((3, 5, 1))] == 1.0


def test_forecasts_of_a_silent_teammate_see_over_levels():
    volume = np.full(tuple(SMALL), FREE, np.uint8)
    belief = np.where(SMALL.between, OCCUPIED, UNKNOWN).astype(np.uint8)
    belief[SMALL.cell((0, 0, 0))] = FREE
    world = World(scenario("small-storeys").with_settings({"team": 2, "goal_of": "every"}))
    world.reset([3])
    sharing = MapSharing(world.briefing(0, 0), Paths(SMALL.shape, SMALL.rise), lidar_model(2.0, "exact", SMALL.number))
    mate = SilentMate(belief, Mate(1, SMALL.cell((0, 0, 0)), 0, None))
    track = sharing._forecast(view_of(plane_of(volume, OCCUPIED), SMALL.cell((3, 5, 4))), mate, 40)
    assert {SMALL.voxel((row, col))[0] for row, col in track.tolist()} >= {0, 1, 2}


@pytest.mark.parametrize("name", ["horizon", "dddqn"])
def test_those_that_plan_rooms_cell_by_cell_leave_small_maps_of_levels_to_others(name):
    small = replace(BRIEFING, shape=(15, 16), level_count=2)
    one = replace(small, level_count=1)
    policy = make_policy(name)
    assert _rise_of(policy.pilot(small)) == 8
    assert type(policy.pilot(one)) is not type(policy.pilot(small))


def _rise_of(pilot: object) -> int:
    return int(pilot.paths.rise)  # type: ignore[attr-defined]


def test_the_warmest_neighbours_may_be_above_and_below():
    pilot = make_policy("hedac").pilot(BRIEFING)
    pilot.explaining = True
    view = explored(20)
    assert view.legal[int(Action.STAY) + 1 :].any()
    pilot.act(view)
    assert pilot.explain().candidates
