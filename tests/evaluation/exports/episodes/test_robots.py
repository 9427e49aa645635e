"""Planners that are given views made of an episode's messages decide as they did in the episode."""

import numpy as np
import pytest

from indoor_explorers.env import World, make_policy
from indoor_explorers.env.interfaces import GridFrame, Robot
from indoor_explorers.env.simulation.rollout import make_pilots
from indoor_explorers.evaluation import export_episode
from tests.evaluation.exports.episodes.reading import POLICIES, RESOLUTION, SHAPE, by_step, latest, messages, record_of


@pytest.mark.parametrize("policy", POLICIES)
@pytest.mark.parametrize("seed", [0, 1])
def test_views_and_decisions_are_those_of_the_episode(folder, results, tmp_path, policy, seed):
    record, scenario = record_of(results, policy, "hall", seed)
    topics = by_step(list(messages(export_episode(folder, tmp_path / "a.mcap", policy=policy, map="hall", seed=seed))))
    world = World(scenario)
    world.begin(0, seed, floorplan=record.floorplan)
    pilots, others = (make_pilots(make_policy(policy), world) for _ in range(2))
    frame = GridFrame(shape=SHAPE, resolution=RESOLUTION)
    robots = [Robot(frame, budget=record.budget) for _ in range(3)]
    said = [None] * 3
    for step in range(record.steps):
        for uav, robot in enumerate(robots):
            for mate in range(3):
                heard = topics[f"/uav_{uav}/heard/uav_{mate}"].get(step)
                if heard is not None:
                    robot.hear(mate, heard, said[mate])
            view = robot.view(latest(topics[f"/uav_{uav}/map"], step), topics[f"/uav_{uav}/pose"][step])
            given = world.view(0, uav)
            for name, value in given._asdict().items():
                np.testing.assert_equal(getattr(view, name), value, err_msg=f"{name} at step {step}")
            action = others[0, uav].act(view)
            assert action == pilots[0, uav].act(given) == record.actions[step, uav]
            goal, there = robot.goal(action), topics[f"/uav_{uav}/pose"][step + 1].pose.position
            here = topics[f"/uav_{uav}/pose"][step].pose.position
            assert (there.x, there.y) in ((goal.x, goal.y), (here.x, here.y))  # a teammate may be in the way
            world.post(0, uav, pilots[0, uav].message)
        said = [others[0, uav].message for uav in range(3)]
        world.step(record.actions[step][None])
    assert not world.flying.any()
    assert (world.state.last_received_step[0] >= 0).any()
