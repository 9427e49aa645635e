"""A UAV that has nothing left to explore flies to a teammate that lacks parts of its map, and meets it."""

from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import FREE, OCCUPIED, UNKNOWN, Mate, View, World, make_policy, scenario
from indoor_explorers.env.policies.view import Briefing
from indoor_explorers.env.sensing.lidar import lidar_model
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot
from indoor_explorers.planners.toolbox.navigation.map_sharing import MOST_FORECASTS, MapSharing
from indoor_explorers.planners.toolbox.navigation.paths import Paths
from tests.planners.flights import view_of

RULES = {"goal_of": "every", "radio.model": "disc", "radio.range": 3.0}


def briefing_of(**settings: object) -> Briefing:
    world = World(scenario("thesis-team-2").with_settings(RULES | {"team": 2} | settings))
    world.reset([0])
    return world.briefing(0, 0)


def corridor(known: slice) -> np.ndarray:
    """Return the map of a corridor of 58 cells, of which some are known."""
    belief = np.full((3, 60), OCCUPIED, np.uint8)
    belief[1, 1:-1] = UNKNOWN
    belief[1, known] = FREE
    return belief


def view(known: slice, col: int, mate: int, age: int) -> View:
    return view_of(corridor(known), (1, col), (Mate(1, (1, mate), age, None),))


def sharing_after_parting(briefing: Briefing) -> MapSharing:
    """Return the sharing of a UAV that knew the left 30 cells when its teammate, then in column 20, fell silent."""
    sharing = MapSharing(briefing, Paths((3, 60)), lidar_model(float(briefing.lidar_range)))
    sharing.observe(view(slice(1, 31), 20, 20, 0))
    sharing.observe(view(slice(1, 31), 20, 20, 1))
    return sharing


@pytest.mark.parametrize(
    ("settings", "needed"),
    [
        ({}, True),
        ({"goal_of": "team"}, False),
        ({"radio.model": "unlimited"}, False),
        ({"radio.model": "none"}, False),
        ({"team": 1}, False),
    ],
)
def test_maps_are_shared_where_all_must_know_them_and_contact_can_be_lost(
    settings: dict[str, object], needed: bool
) -> None:
    assert MapSharing.is_needed(briefing_of(**settings)) is needed


def test_the_teammate_is_met_on_its_way_to_what_it_does_not_know() -> None:
    """After 8 steps it is forecast in column 28; the UAV at the far end meets it half way, 3 cells before contact."""
    sharing = sharing_after_parting(briefing_of())
    path = sharing.path(view(slice(1, 59), 58, 20, 8))
    assert path[0] == (1, 58)
    assert path[1] == (1, 57)
    assert 41 <= path[-1][1] <= 44


def test_nobody_is_met_who_is_in_contact_or_knows_as_much() -> None:
    sharing = sharing_after_parting(briefing_of())
    assert sharing.path(view(slice(1, 31), 20, 20, 8)) == []
    sharing.observe(view(slice(1, 59), 58, 57, 0))
    assert sharing.path(view(slice(1, 59), 58, 57, 0)) == []


def test_a_teammate_that_is_never_where_it_is_expected_is_given_up() -> None:
    """The UAV flies along the corridor again and again; every forecast is contradicted in the end."""
    sharing = sharing_after_parting(briefing_of())
    col, age, flown = 58, 8, 0
    while path := sharing.path(view(slice(1, 59), col, 20, age)):
        col, age, flown = (path[1] if len(path) > 1 else path[0])[1], age + 1, flown + 1
        assert flown < 60 * MOST_FORECASTS
    assert flown > 10


def steps_of(seed: int) -> int:
    """Return the length of a flight of three UAVs until all know the map."""
    settings = {"team": 3, "radio.range": 4.0, "goal_of": "every", "goal": 1.0, "budget": 2000}
    world = World(scenario("small-floors").with_settings(settings))
    world.reset([seed])
    policy = make_policy("frontier-nearest")
    pilots = make_pilots(policy, world)
    return sum(1 for _ in rollout(world, ask_pilots(policy, pilots, world)))


def test_teams_end_sooner_than_by_waiting(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same flights without it take longer on average."""
    seeds = range(8)
    shared = [steps_of(seed) for seed in seeds]
    monkeypatch.setattr(GoalPilot, "_share_map", lambda *_: None)
    waited = [steps_of(seed) for seed in seeds]
    assert np.mean(shared) < np.mean(waited)
