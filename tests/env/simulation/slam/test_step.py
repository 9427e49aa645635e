"""The step with errors against a slow world that was written from the rules, state by state."""

import numpy as np
import pytest

from tests.env.simulation.slam.flights import EVERYTHING, SWITCHES, begun, disc, random_actions, task
from tests.env.simulation.slam.reference import BASE, SlowWorld
from tests.marks import spread

TEAMS = {
    "alone": (1, {}),
    "two linked now and then": (2, disc(4.0)),
    "three with a radio that fails": (3, disc(5.0, loss=0.5)),
    "three with no radio": (3, {}),
}
SPECIAL = {
    "the ancestor's lidar": (2, disc(4.0), EVERYTHING, {"lidar.model": "marsexplorer", "lidar.range": 4.0}),
    "a base": (3, disc(2.5), EVERYTHING, {"base.at": "start"}),
    "a base, to which all must return": (
        2,
        disc(2.0, loss=0.3),
        EVERYTHING,
        {"base.at": "start", "base.must_return": True, "goal": 0.4},
    ),
    "UAVs that stop": (3, disc(3.0), EVERYTHING, {"failures.hazard": 0.04, "failures.reward": -3.0}),
    "UAVs that stop with a last word": (
        3,
        disc(4.0),
        EVERYTHING,
        {"failures.stops": ((0, 7), (2, 12)), "failures.last_word": True, "base.at": "start"},
    ),
    "radios that fall silent": (2, disc(9.0), EVERYTHING, {"failures.radio_hazard": 0.2, "failures.radio_outage": 4}),
    "collisions that end": (3, disc(4.0), EVERYTHING, {"on_collision": "end", "rewards.collision": -7.0}),
    "a goal of the agent": (2, disc(4.0), EVERYTHING, {"goal_of": "agent", "goal": 0.5, "rewards.received": 0.5}),
    "a radio without limits": (3, {"radio.model": "unlimited"}, EVERYTHING),
    "a goal of the team": (2, {}, EVERYTHING, {"goal": 0.6}),
    "coverage of all cells": (2, disc(4.0), EVERYTHING, {"denominator": "map", "goal": 0.9}),
}


#: Attributes of a slow UAV, by the names that they have in the state.
COUNTED = (
    "cell",
    "end",
    "reward",
    "discovered",
    "received",
    "collisions",
    "blocked",
    "path_length",
    "sent_bytes",
    "silent_until",
)


def mask(shape, cells):
    """(H, W) bool of some cells."""
    found = np.zeros(shape, bool)
    for cell in cells:
        found[cell] = True
    return found


def expected(slow):
    """What the slow world says of an episode: of the team, and lists over the agents."""
    uavs, team, shape = slow.uavs, slow.team, slow.truth.shape
    beliefs, union = [slow.belief(n) for n in team], slow.shown(slow.team_log_odds())
    facts = {name: [getattr(uav, name) for uav in uavs] for name in COUNTED}
    return facts | {
        "step": slow.step_number,
        "believed_cell": [uav.believed for uav in uavs],
        "log_odds": [*(slow.log_odds(n) for n in team), slow.team_log_odds()],
        "belief": beliefs,
        "union": union,
        "covered": [slow.right(belief) for belief in beliefs],
        "team_covered": slow.right(union),
        "legal": [slow.legal(n) for n in team],
        "visited": [mask(shape, uav.visited) for uav in uavs],
        "sensed": [mask(shape, uav.sensed) for uav in uavs],
        "sensed_count": [int(slow.counts[mask(shape, uav.sensed)].sum()) for uav in uavs],
        "known": [len(uav.listed) for uav in uavs],
        "linked": [[frozenset((n, m)) in slow.links for m in team] for n in team],
        "last_received_step": [[uav.heard.get(m, (-1,))[0] for m in team] for uav in uavs],
        "last_received_cell": [[uav.heard.get(m, (-1, (0, 0)))[1] for m in team] for uav in uavs],
    }


def of_base(slow):
    return {
        "base_belief": slow.shown(slow.log_odds(BASE)),
        "base_covered": slow.right(slow.shown(slow.log_odds(BASE))),
        "base_contact": [n in slow.reported for n in slow.team],
        "base_step": [slow.contacts.get(n, -1) for n in slow.team],
    }


def compare(world, slow):
    """Assert that the two worlds are in the same state."""
    found, facts = {**world.state._asdict(), "log_odds": world.slam.log_odds[:, : len(slow.uavs) + 1]}, expected(slow)
    if world.scenario.base.exists:
        facts |= of_base(slow)
        np.testing.assert_array_equal(world.slam.log_odds[0, -1], slow.log_odds(BASE), "log-odds of the base")
    for name, value in facts.items():
        np.testing.assert_array_equal(found[name][0], np.array(value), f"{name} in step {slow.step_number}")
    np.testing.assert_allclose(world.slam.pose_error[0], [uav.pose_error for uav in slow.uavs], rtol=1e-12)
    for n, uav in enumerate(slow.uavs):
        view = world.view(0, n)
        assert view.pose_std == float(uav.variances[-1]) ** 0.5
        assert view.heading == (uav.headings[-1] if world.scenario.turns else None)


def hold_against(scenario, seed, steps):
    """Fly at random and compare each state; returns the world at the end."""
    world = begun(scenario, seed)
    slow, rng = SlowWorld(world, seed), np.random.default_rng(seed)
    compare(world, slow)
    for _ in range(steps):
        actions = random_actions(rng, world)
        world.step(actions[None])
        slow.step(actions)
        compare(world, slow)
    return world


@pytest.mark.parametrize(("switch", "seed"), spread([*SWITCHES], [3, 4]))
def test_a_switch_alone(switch, seed):
    hold_against(task(2, disc(4.0), SWITCHES[switch]), seed, steps=30)


@pytest.mark.parametrize(("team", "seed"), spread([*TEAMS], [1, 2]))
def test_all_switches(team, seed):
    size, radio = TEAMS[team]
    hold_against(task(size, radio, EVERYTHING), seed, steps=30)


@pytest.mark.parametrize(("case", "seed"), spread([*SPECIAL], [11, 12]))
def test_all_switches_and(case, seed):
    size, *changes = SPECIAL[case]
    world = hold_against(task(size, *changes), seed, steps=30)
    sums = world.slam.log_odds.astype(np.float64) * 32
    np.testing.assert_array_equal(sums, np.round(sums), "sums of readings, multiples of 1/32, are exact")
