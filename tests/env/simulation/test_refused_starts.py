"""Episodes that cannot be started are refused, and leave the batch as it was."""

from contextlib import suppress

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, InputError, LivePlanes, Scenario, World, scenario
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.interfaces.vector import IndoorExplorersVectorEnv
from indoor_explorers.env.maps.floorplan import Floorplan

#: Rooms drawn in compiled code; a team of 22 fits into those of seeds 3, 8, 12, not into those of 0, 1 and 2.
CROWDED = Scenario(map={"source": "thesis", "height": 6, "width": 6, "obstacles": 6}, team=22)
#: Rooms drawn in Python; the spawn is free in those of seeds 0 and 3, not in that of 1.
LISTED = Scenario(map={"source": "thesis", "obstacles": 12}, spawn=((7, 7),), on_collision="block", budget=40)
HALL = Floorplan(np.full((20, 24), FREE, np.uint8), "hall")


def snapshot(world):
    """All that a batch of episodes is."""
    arrays = {name: array.copy() for name, array in world.state._asdict().items()}
    facts = {"seeds": world.seeds.copy(), "begun": world.begun.copy()}
    maps = {f"map {b}": world.floorplan(b).digest for b in range(world.batch)}
    return arrays | facts | maps


def assert_unchanged(world, before):
    for name, value in snapshot(world).items():
        np.testing.assert_array_equal(value, before[name], err_msg=name)


def test_a_room_of_another_shape_is_no_episode_of_the_batch():
    world = World(scenario("thesis-obstacles"), 2)
    world.begin(0, 3, floorplan=HALL)
    for start in (lambda: world.begin(1, 5), lambda: world.restart([1, 0], [5, 6])):
        with pytest.raises(InputError, match=r"expected a map of shape \(20, 24\) like the others .* got \(16, 16\)"):
            start()
    assert world.state.truth.shape == (2, 20, 24)
    assert (world.state.truth[1] == 0).all()


def test_a_new_world_that_refused_an_episode_is_still_new():
    world = World(CROWDED)
    with pytest.raises(InputError, match="expected room for 22 UAVs"):
        world.reset([0])
    with pytest.raises(InputError, match="got a new one"):
        _ = world.state
    world.begin(0, 0, floorplan=HALL)
    assert world.state.truth.shape == (1, 20, 24)


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize(
    ("task", "good", "bad", "message"),
    [
        (CROWDED, 3, 0, "expected room for 22 UAVs"),
        (LISTED, 0, 1, r"spawn 0 at \(7, 7\) is no free cell"),
        (PRESETS["thesis-team-2"], 0, -1, "expected a seed from 0 to 9223372036854775807"),
        (PRESETS["thesis-team-2"], 0, 2**63, "expected a seed from 0 to 9223372036854775807"),
    ],
)
def test_a_refused_restart_leaves_every_episode_as_it_was(task, good, bad, message, threads):
    world = World(task, 40, threads=threads)
    world.reset([good] * 40)
    live, rng = LivePlanes(world), np.random.default_rng(0)
    for _ in range(3):
        live.step(rng.integers(0, 5, (40, task.team)))
    before, planes = snapshot(world), live.planes.copy()
    for place in (0, 1, 20, 39):
        seeds = [good] * 40
        seeds[place] = bad
        with pytest.raises(InputError, match=message):
            world.restart(range(40), seeds)
        assert_unchanged(world, before)
        np.testing.assert_array_equal(live.update(), planes)


@pytest.mark.parametrize(
    ("start", "message"),
    [
        (lambda world: world.restart([0, 2], [5, 6]), r"expected episodes from 0 to 1, got \[0, 2\]"),
        (lambda world: world.restart([0, -1], [5, 6]), "expected episodes from 0 to 1"),
        (lambda world: world.restart([1, 1], [5, 6]), r"expected each episode once, got \[1, 1\]"),
        (lambda world: world.restart([0, 1], [5]), "expected one seed for each of 2 episodes, got 1"),
        (lambda world: world.restart([0, 1], [5, 6], index=1), "expected index to be one of the scenario's 1 maps"),
        (lambda world: world.begin(2, 5, floorplan=world.floorplan(0)), "expected episodes from 0 to 1"),
        (lambda world: world.begin(0, 5, spawns=[(0, 0)]), "expected a spawn for each of 2 UAVs, got 1"),
        (lambda world: world.begin(0, 5, floorplan=HALL), "expected a map of shape"),
        (
            lambda world: world.begin(
                0, 5, floorplan=Floorplan(np.where(np.arange(256).reshape(16, 16), 2, 1).astype(np.uint8), "cupboard")
            ),
            "cupboard: expected room for 2 UAVs, got 1",
        ),
    ],
)
def test_wrong_arguments_are_refused_before_anything_changes(start, message):
    world = World(PRESETS["thesis-team-2"], 2)
    world.reset([0, 1])
    before = snapshot(world)
    with pytest.raises(InputError, match=message):
        start(world)
    assert_unchanged(world, before)


@pytest.mark.parametrize("autoreset_mode", ["NEXT_STEP", "SAME_STEP", "DISABLED"])
@pytest.mark.parametrize("observation", ["channels", "thesis"])
def test_a_refused_reset_of_environments_changes_nothing(observation, autoreset_mode):
    def flown(refused):
        envs = IndoorExplorersVectorEnv(2, LISTED, observation, autoreset_mode=autoreset_mode)
        envs.reset(seed=[0, 3])
        results = [envs.step(np.array([4, 4]))]
        for seed in refused:
            with pytest.raises(InputError, match="is no free cell"):
                envs.reset(seed=seed)
        results += [envs.step(np.array(actions)) for actions in ([0, 1], [2, 3], [3, 0])]
        return results, envs.world.seeds, [rng.bit_generator.state for rng in envs._generators]

    plain, refused = flown([]), flown([[3, 1], [1, 0]])
    assert plain[1:] == refused[1:]
    for one, other in zip(plain[0], refused[0], strict=True):
        for k in range(4):
            np.testing.assert_array_equal(one[k], other[k])


def test_a_refused_start_in_the_step_that_ended_an_episode_is_told_by_the_next_step():
    envs = IndoorExplorersVectorEnv(2, LISTED, autoreset_mode="SAME_STEP")
    envs.reset(seed=[0, 3])
    over, refusals = np.zeros(2, np.bool_), 0
    for _ in range(400):
        before = snapshot(envs.world)
        try:
            observed, _, terminated, truncated, infos = envs.step(np.array([0, 1]))
        except InputError:
            refusals += 1
            assert over.any()
            assert_unchanged(envs.world, before)
            continue
        over = terminated | truncated
        for b in np.flatnonzero(over):
            assert infos["final_info"]["end"][b] > 0
            restarted = envs.world.state.step[b] == 0
            assert np.array_equal(observed[b], infos["final_obs"][b]) is not restarted
    assert refusals > 0
    envs.reset(seed=[0, 3])
    envs.step(np.array([0, 1]))


def test_a_step_whose_next_episode_is_refused_flies_nothing():
    envs = IndoorExplorersVectorEnv(2, LISTED)
    envs.reset(seed=[0, 3])
    refusals = 0
    for _ in range(400):
        before = snapshot(envs.world)
        with suppress(InputError):
            envs.step(np.array([0, 1]))
            continue
        refusals += 1
        assert_unchanged(envs.world, before)
    assert refusals > 0
