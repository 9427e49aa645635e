"""The guard: no episode freezes, dithers or loops, whatever the network says."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from indoor_explorers.env import PRESETS, Action, Briefing, Pilot, Policy, Scenario, View
from indoor_explorers.env.maps import Floorplan
from indoor_explorers.env.simulation.world import World
from indoor_explorers.learners.dddqn.policy import Dddqn
from indoor_explorers.learners.guard import Guard, nearest_frontier
from indoor_explorers.learners.thesis.policy import DddqnThesis
from tests.learners.dddqn.rooms import fly, maze
from tests.learners.thesis.rooms import MENDED_FORMAT, write_network


class Stubborn(Policy):
    """Propose the same move, or the legal move of lowest number, for ever; only the guard saves it."""

    def pilot(self, briefing: Briefing) -> StubbornPilot:
        return StubbornPilot(briefing)


class StubbornPilot(Pilot):
    def __init__(self, briefing: Briefing) -> None:
        self.guard = Guard(briefing.shape, briefing.rng)

    def act(self, view: View) -> int:
        queue, steps = np.empty(view.belief.size, np.int32), np.empty(view.belief.shape, np.int32)
        if nearest_frontier(view.belief, *view.cell, queue, steps) < 0:
            self.guard.rest()
            return Action.STAY
        return self.guard.review(view, int((view.belief != 0).sum()), int(view.legal[:4].argmax()))


def task(team: int = 1, radio: str = "none", budget: int = 20_000, lidar: float = 3.0) -> Scenario:
    settings = {"team": team, "radio.model": radio, "radio.range": 3, "budget": budget, "lidar.range": lidar}
    return PRESETS["thesis-obstacles"].for_evaluation().with_settings(settings)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("team", "radio"), [(1, "none"), (3, "none"), (4, "square")])
def test_a_stubborn_policy_finishes_mazes(team: int, radio: str, seed: int) -> None:
    free = maze(np.random.default_rng(seed))
    world = fly(Stubborn(), task(team, radio), seed, free)
    assert world.team_coverage[0] == 1.0
    assert world.state.collisions.sum() == 0


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("lidar", [1.0, 10.0])
def test_an_untrained_network_finishes_mazes(untrained: str, seed: int, lidar: float) -> None:
    free = maze(np.random.default_rng(100 + seed))
    world = fly(Dddqn(weights=untrained), task(2, lidar=lidar), seed, free)
    assert world.team_coverage[0] == 1.0


@pytest.mark.slow
@pytest.mark.parametrize("mask", [True, False])
@pytest.mark.parametrize("seed", range(3))
def test_a_network_that_flies_into_walls_finishes_mazes_with_the_guard(mask: bool, seed: int, tmp_path: Path) -> None:
    weights = write_network(tmp_path / "untrained.safetensors", 3, MENDED_FORMAT)
    free = maze(np.random.default_rng(200 + seed))
    scenario = task(2).with_settings({"on_collision": "block"})
    lost = fly(DddqnThesis(weights=weights, mask=mask), scenario.with_settings({"budget": 2_000}), seed, free)
    assert lost.team_coverage[0] < 1.0
    world = World(scenario)
    world.begin(0, seed, floorplan=Floorplan.from_free(free, "maze"))
    pilots = [DddqnThesis(weights=weights, mask=mask, guard=True).pilot(world.briefing(0, n)) for n in range(2)]
    while world.flying.any():
        world.step(np.array([[pilots[n].act(world.view(0, n)) for n in range(2)]]))
    assert world.team_coverage[0] == 1.0
    assert all(0.1 < pilot.tally()["guarded_share"] < 1.0 for pilot in pilots)


def test_two_uavs_that_want_past_each_other_in_a_corridor_do() -> None:
    free = np.zeros((7, 23), np.bool_)
    free[3] = True
    free[:, :2] = free[:, -2:] = True
    for seed in range(10):
        world = World(task(2).with_settings({"spawn": [[3, 10], [3, 11]], "lidar.range": 1.0}))
        world.begin(0, seed, floorplan=Floorplan.from_free(free, "corridor"))
        pilots = [StubbornPilot(world.briefing(0, n)) for n in range(2)]
        while world.flying.any():
            world.step(np.array([[pilots[n].act(world.view(0, n)) for n in range(2)]]))
        assert world.team_coverage[0] == 1.0


def test_it_waits_as_long_as_it_says_and_hands_back_after_a_gain() -> None:
    belief = np.ones((1, 12), np.uint8)
    belief[0, 10:] = 0
    legal = np.array([False, True, False, True, True])
    guard = Guard(belief.shape, np.random.default_rng(0))
    col, shares = 4, []
    for step in range(40):
        if step == 30:
            belief[0, 10] = 1
        proposal = (Action.LEFT, Action.LEFT, Action.RIGHT, Action.RIGHT)[step % 4]
        view = View(belief, (0, col), legal, step, 99, (), np.zeros(belief.shape, np.bool_))
        action = guard.review(view, int((belief != 0).sum()), proposal)
        col += {Action.LEFT: -1, Action.RIGHT: 1, Action.STAY: 0}[Action(action)]
        shares.append(guard.guarded)
    first = shares.index(1)
    # The gain stopped at step 1 in column 3, six steps from the frontier in column 9.
    assert first == 2 * 6 + 1
    assert shares[29] == 30 - first
    assert shares[30] == shares[31] == shares[29]


def test_nothing_unknown_in_reach_means_staying(untrained: str) -> None:
    free = np.zeros((5, 9), np.bool_)
    free[:, :3] = free[:, 6:] = True
    scenario = task(2).with_settings({"spawn": [[2, 1], [2, 7]], "goal_of": "agent", "budget": 80})
    world = fly(Dddqn(weights=untrained), scenario, 1, free)
    assert world.state.collisions.sum() == 0
    resting = world.state.path_length
    assert (resting < 60).all()


def actions_of(policy: Policy, seed: int) -> Sequence[NDArray[np.int64]]:
    world = fly(policy, task(3), seed, maze(np.random.default_rng(seed)))
    return [world.state.cell.copy(), world.state.step.copy(), world.state.path_length.copy()]


def test_backing_off_is_random_but_repeatable(untrained: str) -> None:
    policy = Dddqn(weights=untrained)
    for first, second in zip(actions_of(policy, 3), actions_of(policy, 3), strict=True):
        assert np.array_equal(first, second)
