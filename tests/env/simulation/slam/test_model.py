"""Laws of worlds whose sensors and poses err: what they share with exact ones, and what their episodes depend on."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_explorers.env import InputError, World
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, TURN
from indoor_explorers.env.maps.floorplan import Floorplan
from tests.env import worlds
from tests.env.simulation.slam.flights import EVERYTHING, NEVER, begun, disc, random_actions, random_plan, task

seeds = st.integers(0, 2**32)
examples = settings(max_examples=12, deadline=None)
#: Of the state: all that an exact world and one without errors agree on. They count bytes, and log cells, otherwise.
ALIKE = (
    *("step", "end", "cell", "legal", "belief", "sensed", "visited", "union", "covered", "team_covered"),
    *("sensed_count", "known", "discovered", "received", "idle", "history", "reward", "linked", "silent_until"),
    *("last_received_step", "last_received_cell", "last_received", "last_received_size", "path_length"),
    *("collisions", "blocked", "base_belief", "base_covered", "base_contact", "base_step"),
)
ROOM = {"map.height": 9, "map.width": 11, "map.obstacles": 2}


def same_views(one, other):
    """Whether two views hold the same."""
    pairs = zip(one, other, strict=True)
    return all(np.array_equal(a, b) if isinstance(a, np.ndarray) else a == b for a, b in pairs)


@settings(max_examples=25, deadline=None)
@given(worlds.scenarios(), worlds.floorplans(), seeds)
def test_errors_that_never_happen_give_the_exact_world(scenario, floorplan, seed):
    exact = worlds.begun(scenario, floorplan, seed)
    never = worlds.begun(scenario.with_settings(NEVER), floorplan, seed)
    assert never.slam is not None
    rng = np.random.default_rng(seed)
    for _ in range(25):
        for name in ALIKE:
            np.testing.assert_array_equal(getattr(never.state, name), getattr(exact.state, name), name)
        np.testing.assert_array_equal(never.state.believed_cell, exact.state.cell)
        actions = worlds.random_actions(rng, exact)
        for world in (exact, never):
            world.step(actions)


@examples
@given(seeds, st.integers(1, 3))
def test_an_episode_is_a_function_of_its_seed_and_actions(seed, team):
    scenario = task(team, disc(4.0), EVERYTHING, {"failures.hazard": 0.02}).with_settings(ROOM)
    drawn = np.random.default_rng(seed).integers(0, scenario.actions, (20, 3, team))
    episode_seeds = [seed, seed + 1, seed + 2]
    batches = [World(scenario, 3), World(scenario, 3, threads=2)]
    alone = [World(scenario) for _ in range(3)]
    alone[2].reset([seed + 7])  # an earlier episode in the same place leaves nothing behind
    alone[2].step(drawn[0, :1])
    for world, flown in zip((*batches, *alone), (episode_seeds,) * 2 + tuple([s] for s in episode_seeds), strict=True):
        world.reset(flown)
    for actions in drawn:
        for world in batches:
            world.step(actions)
        for b, world in enumerate(alone):
            world.step(actions[b : b + 1])
            for batch in batches:
                assert all(same_views(world.view(0, n), batch.view(b, n)) for n in range(team))
                for name, array in world.state._asdict().items():
                    np.testing.assert_array_equal(array[0], getattr(batch.state, name)[b], name)


def test_an_episode_begins_anew_beside_others():
    """One place of a batch begins another episode: it is that of a new world, and the other one goes on."""
    scenario = task(2, disc(4.0), EVERYTHING).with_settings(ROOM)
    batch, alone, fresh = World(scenario, 2), World(scenario), World(scenario)
    batch.reset([1, 2])
    alone.reset([1])
    drawn = np.random.default_rng(0).integers(0, scenario.actions, (30, 2, 2))
    for step, actions in enumerate(drawn):
        if step == 15:
            batch.restart([1], [3])
            fresh.reset([3])
        batch.step(actions)
        alone.step(actions[:1])
        assert all(same_views(batch.view(0, n), alone.view(0, n)) for n in range(2))
        if step >= 15:
            fresh.step(actions[1:])
            assert all(same_views(batch.view(1, n), fresh.view(0, n)) for n in range(2))


@examples
@given(seeds, st.integers(1, 3))
def test_a_view_depends_on_no_cell_out_of_the_lidars_reach(seed, team):
    """Cells that no scan can have met are drawn anew: no view changes."""
    scenario = task(team, disc(4.0), EVERYTHING, {"lidar.range": 2.0})
    first = begun(scenario, seed, plan := random_plan(seed, (14, 14)))
    spawns = [tuple(cell) for cell in first.state.cell[0].tolist()]
    rng, flown, views, been = np.random.default_rng(seed), [], [], set(spawns)
    for _ in range(15):
        views.append([copied(first.view(0, n)) for n in range(team)])
        flown.append(random_actions(rng, first)[None])
        been |= {tuple(cell) for cell in first.state.cell[0].tolist()}
        first.step(flown[-1])
    been |= {tuple(cell) for cell in first.state.cell[0].tolist()}
    apart = np.linalg.norm(np.indices(plan.shape)[:, :, :, None] - np.array(sorted(been)).T[:, None, None], axis=0)
    hidden = apart.min(axis=2) > 2.0 + 1.0
    truth = np.where(hidden & (rng.random(plan.shape) < 0.5), FREE + OCCUPIED - plan.truth, plan.truth)
    second = World(scenario)
    second.begin(0, seed, floorplan=Floorplan(truth.astype(np.uint8), "changed"), spawns=spawns)
    for actions, before in zip(flown, views, strict=True):
        assert all(same_views(second.view(0, n), before[n]) for n in range(team))
        second.step(actions)


def copied(view):
    return view._replace(**{name: value.copy() for name, value in view._asdict().items() if hasattr(value, "copy")})


@examples
@given(seeds)
def test_views_tell_nothing_of_where_the_uav_truly_is(seed):
    """In a hall whose walls are out of reach, a UAV that starts elsewhere has the same views, moved by as much."""
    hall = Floorplan(np.full((40, 40), FREE, np.uint8), "hall")
    scenario = task(1, {"drift.rate": 0.4, "drift.closure_gap": 3, "lidar.field_of_view": 100.0})
    near, far = World(scenario), World(scenario)
    near.begin(0, seed, floorplan=hall, spawns=[(18, 17)])
    far.begin(0, seed, floorplan=hall, spawns=[(20, 22)])
    for action in np.random.default_rng(seed).integers(0, 6, 12):
        for world in (near, far):
            world.step(np.array([[action]]))
        one, other = near.view(0, 0), far.view(0, 0)
        assert (one.cell[0] + 2, one.cell[1] + 5) == other.cell
        for name in ("belief", "log_odds", "visited"):
            np.testing.assert_array_equal(np.roll(getattr(one, name), (2, 5), (0, 1)), getattr(other, name))
        assert (one.heading, one.pose_std, one.legal.tolist()) == (other.heading, other.pose_std, other.legal.tolist())


def test_the_view_of_a_uav_that_has_ended_stays_as_it_was():
    scenario = task(2, EVERYTHING, {"failures.stops": ((0, 6),)})
    world = World(scenario)
    for seed in (1, 2):  # what the first episode leaves behind must not show
        world.begin(0, seed, floorplan=random_plan(seed))
        rng, ended = np.random.default_rng(seed), None
        for _ in range(15):
            world.step(random_actions(rng, world)[None])
            if not world.flying[0, 0]:
                view = world.view(0, 0)
                ended = ended or (view.pose_std, view.heading, view.cell)
                assert (view.pose_std, view.heading, view.cell) == ended
        assert ended is not None


def test_what_only_uncertain_maps_have():
    world = begun(task(1), 3)
    view = world.view(0, 0)
    assert (world.slam, view.log_odds, view.pose_std, view.heading) == (None, None, 0.0, None)
    assert set(np.unique(view.occupancy)) <= {0.0, 0.5, 1.0}
    assert ((view.occupancy == 1.0) == (view.belief == OCCUPIED)).all()
    world = begun(task(1, {"noise.misses": 0.1}), 3)
    view = world.view(0, 0)
    assert view.heading is None
    np.testing.assert_allclose(np.log(view.occupancy / (1 - view.occupancy)), view.log_odds, rtol=1e-6)
    assert ((view.occupancy > 0.5) == (view.belief == OCCUPIED)).all()
    with pytest.raises(ValueError, match="read-only"):
        view.log_odds[0, 0] = 1.0


def test_turning_needs_a_limited_field_of_view():
    world = begun(task(1, {"noise.misses": 0.1}), 3)
    with pytest.raises(InputError, match="expected an action from 0 to 4, got 5"):
        world.step(np.array([[TURN]]))
