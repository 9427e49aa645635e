"""Lidars and radios of plug-ins: the same rules give the same episodes as compiled ones, and other rules are kept."""

import numpy as np
import pytest

from indoor_explorers.env import InputError, Scenario, World, make_policy, scenario
from indoor_explorers.env.errors import RunError
from indoor_explorers.env.rendering import paint, scene_of
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.evaluation.harness.episodes.lower_bounds import least_steps
from tests.env import plugins

HERE = plugins.__name__
TEAM = scenario("thesis-team-4").for_evaluation().with_settings({"radio.model": "disc", "radio.range": 4.0})


def flown(task: Scenario, seeds=(1, 2), steps=30, threads=1) -> World:
    """A batch after some random steps."""
    world, rng = World(task, len(seeds), threads=threads), np.random.default_rng(0)
    world.reset(seeds)
    for _ in range(steps):
        world.step(rng.integers(0, 5, (len(seeds), task.team)))
    return world


@pytest.mark.parametrize(
    "settings",
    [
        {"lidar.model": f"{HERE}:exact"},
        {"radio.model": f"{HERE}:disc"},
        {"lidar.model": f"{HERE}:exact", "radio.model": f"{HERE}:disc"},
    ],
    ids=["lidar", "radio", "both"],
)
@pytest.mark.parametrize("more", [{}, {"radio.loss": 0.4}, {"on_collision": "end", "goal_of": "agent", "goal": 0.3}])
def test_the_same_rules_give_the_same_episodes(settings, more):
    task = TEAM.with_settings(more)
    own, compiled = flown(task.with_settings(settings)), flown(task)
    for name, array in compiled.state._asdict().items():
        found = getattr(own.state, name)
        if name == "discovery_log":  # the cells of one scan are entered in another order
            found, array = np.sort(found), np.sort(array)
        np.testing.assert_array_equal(found, array, err_msg=name)


def test_threads_do_not_matter():
    task = TEAM.with_settings({"lidar.model": f"{HERE}:exact", "radio.model": f"{HERE}:disc"})
    one, two = flown(task, seeds=(1, 2, 3)), flown(task, seeds=(1, 2, 3), threads=2)
    np.testing.assert_array_equal(one.state.belief, two.state.belief)


def test_a_plug_in_s_lidar_decides_what_is_known_and_drawn():
    world = World(TEAM.with_settings({"team": 1, "lidar.model": f"{HERE}:square_view"}))
    world.reset([5])
    row, col = world.state.cell[0, 0]
    seen = plugins.square_view(world.state.truth[0], (row, col), 3.0)
    np.testing.assert_array_equal(world.view(0, 0).belief > 0, seen)
    assert least_steps(world, 0, 0.99) == 0
    assert paint(scene_of(world, 0)).shape[2] == 3


def test_planners_fly_with_plug_ins():
    world = World(TEAM.with_settings({"lidar.model": f"{HERE}:square_view", "radio.model": f"{HERE}:disc"}))
    world.reset([7])
    policy = make_policy("frontier")
    for _ in rollout(world, ask_pilots(policy, make_pilots(policy, world), world)):
        pass
    assert world.team_coverage[0] == 1.0


def test_a_map_generator_of_a_plug_in_is_part_of_the_scenario():
    task = scenario("thesis-open").with_settings({"map.source": f"{HERE}:Pillars", "map.every": 4, "map.width": 20})
    assert isinstance(task.map, plugins.Pillars)
    assert task == Scenario.model_validate(task.model_dump()) == Scenario.model_validate(task.model_dump(mode="json"))
    assert task.map.source == plugins.Pillars().source
    world = World(task)
    world.reset([3])
    assert world.state.truth.shape == (1, 64, 20)
    assert task.fingerprint != task.with_settings({"map.every": 5}).fingerprint


def test_other_code_is_another_task(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "radios_of_a_test.py").write_text("def near(truth, cells, radio): ...\n")
    task = TEAM.with_settings({"radio.model": "radios_of_a_test:near"})
    before = Scenario.model_validate(task.model_dump()).fingerprint
    assert before == Scenario.model_validate(task.model_dump()).fingerprint
    (tmp_path / "radios_of_a_test.py").write_text("def near(truth, cells, radio): return 1\n")
    assert Scenario.model_validate(task.model_dump()).fingerprint != before
    assert TEAM.fingerprint == Scenario.model_validate(TEAM.model_dump()).fingerprint


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"lidar.model": "exct"}, "unknown lidar model 'exct'; did you mean 'exact'"),
        ({"radio.model": "dsic"}, "did you mean 'disc'"),
        ({"radio.model": "no_such_module:near"}, "importing no_such_module raised ModuleNotFoundError"),
        ({"radio.model": f"{HERE}:near"}, "has no 'near'"),
        ({"radio.model": f"{HERE}:NUMBER"}, "expected a function, got int"),
        ({"map.source": f"{HERE}:exact"}, "expected a subclass of GeneratedMaps"),
        ({"map.source": f"{HERE}:Pillars", "map.every": 1}, "every: Input should be greater than or equal to 3"),
    ],
)
def test_what_is_no_plug_in_is_refused_in_one_line(settings, message):
    with pytest.raises(InputError) as refused:
        TEAM.with_settings(settings)
    assert message in str(refused.value)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"radio.model": f"{HERE}:one_way"}, "expected a symmetric mask of shape (4, 4)"),
        ({"lidar.model": f"{HERE}:flat"}, "expected an (H, W) mask of shape (16, 16), got one of shape (256,)"),
        ({"radio.model": f"{HERE}:broken"}, "radio of a plug-in failed: ZeroDivisionError: no antenna"),
    ],
)
def test_a_plug_in_that_fails_is_named(settings, message):
    with pytest.raises(RunError) as failed:
        flown(TEAM.with_settings(settings))
    assert message in str(failed.value)
