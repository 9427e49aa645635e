from __future__ import annotations

import pytest

from indoor_explorers.env import World, scenario
from indoor_explorers.env.grid.cells import TURN
from indoor_explorers.planners.frontier.heading import FrontierHeading
from indoor_explorers.planners.frontier.latency import FrontierLatency, LatencyPilot

WHOLE = {"goal": 1.0, "goal_of": "team", "denominator": "reachable", "stuck.rule": "off"}


def flown(policy: FrontierLatency, settings: dict[str, object], name: str = "thesis-obstacles") -> list[list[int]]:
    """The actions of an episode to full coverage."""
    world = World(scenario(name).with_settings({**WHOLE, **settings}))
    world.reset(seeds=[7])
    team = world.scenario.team
    pilots, actions = [policy.pilot(world.briefing(0, n)) for n in range(team)], []
    while world.flying.any():
        actions.append([pilot.act(world.view(0, n)) for n, pilot in enumerate(pilots)])
        for n, pilot in enumerate(pilots):
            world.post(0, n, pilot.message)
        world.step([actions[-1]])
    assert world.team_coverage.max() == 1.0, "an incomplete map"
    return actions


@pytest.mark.parametrize("degrees", [30.0, 90.0, 180.0])
@pytest.mark.parametrize("slack", [0, 4])
@pytest.mark.parametrize("team", [1, 2])
def test_it_sees_every_cell_of_a_room(degrees: float, slack: int, team: int) -> None:
    settings = {"lidar.field_of_view": degrees, "team": team, "radio.model": "disc", "radio.range": 5.0}
    actions = flown(FrontierHeading(slack=slack, price=1.0), settings)
    assert len(actions) < 250
    assert slack or not any(TURN in step for step in actions)


def test_with_slack_it_turns_in_place() -> None:
    actions = flown(FrontierHeading(slack=4, price=0.0), {"lidar.field_of_view": 90.0})
    assert any(TURN in step for step in actions)


def test_it_sees_every_cell_of_a_small_maze() -> None:
    assert flown(FrontierHeading(), {"lidar.field_of_view": 90.0}, "small-maze")


def test_all_around_it_is_frontier_latency() -> None:
    assert flown(FrontierHeading(), {}) == flown(FrontierLatency(), {})
    world = World(scenario("thesis-obstacles"))
    world.reset(seeds=[1])
    pilot = FrontierHeading().pilot(world.briefing(0, 0))
    assert type(pilot) is LatencyPilot
