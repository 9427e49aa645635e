"""UAVs that stop and radios that are silent: when, who knows what afterwards, and what is lost."""

import numpy as np
import pytest

from indoor_explorers.env import Scenario, World, scenario
from indoor_explorers.env.grid.cells import UNKNOWN
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.simulation.state import End

STAY, RIGHT = 4, 3
CORRIDOR = Floorplan(np.ones((1, 24), np.uint8), "corridor")


def in_corridor(cells, radio=None, **failures):
    """A team in a corridor that sees two cells away and never ends by itself."""
    task = Scenario(
        team=len(cells),
        spawn=tuple((0, cell) for cell in cells),
        lidar={"range": 2.0},
        radio=radio or {},
        failures=failures,
        goal=1.0,
        goal_of="team",
        budget=100_000,
    )
    world = World(task)
    world.begin(0, 7, floorplan=CORRIDOR)
    return world


def stay(world, steps=1):
    for _ in range(steps):
        world.step(np.full(world.state.end.shape, STAY))


def known(world):
    return np.flatnonzero(world.state.union[0, 0] != UNKNOWN).tolist()


def test_a_listed_uav_flies_until_its_step_and_is_gone_then():
    world = in_corridor((0, 10), stops=((1, 3),))
    stay(world, 2)
    assert world.flying.tolist() == [[True, True]]
    world.step(np.array([[STAY, RIGHT]]))
    assert world.state.end[0].tolist() == [End.FLYING, End.STOPPED]
    assert world.state.cell[0, 1].tolist() == [0, 11]
    world.step(np.array([[STAY, RIGHT]]))
    assert world.state.cell[0, 1].tolist() == [0, 11]


def test_what_the_stopped_one_alone_knew_is_lost_and_can_be_seen_again():
    world = in_corridor((0, 4), stops=((1, 2),))
    assert known(world) == [0, 1, 2, 3, 4, 5, 6]
    stay(world, 2)
    assert known(world) == [0, 1, 2]
    assert world.state.team_covered[0] == 3
    for _ in range(3):
        world.step(np.array([[RIGHT, STAY]]))
    assert known(world) == [0, 1, 2, 3, 4, 5]


@pytest.mark.parametrize(("last_word", "kept"), [(False, [0, 1, 2, 3, 4, 5]), (True, [0, 1, 2, 3, 4, 5, 6])])
def test_a_last_word_brings_home_what_was_seen_in_the_last_step(last_word, kept):
    world = in_corridor((1, 3), {"model": "disc", "range": 9.0}, stops=((1, 1),), last_word=last_word)
    assert known(world) == [0, 1, 2, 3, 4, 5]
    world.step(np.array([[STAY, RIGHT]]))
    assert known(world) == kept
    assert np.flatnonzero(world.view(0, 0).belief[0]).tolist() == kept
    age = 0 if last_word else 1
    assert [mate.age for mate in world.view(0, 0).mates] == [age]


def test_a_stop_shows_itself_to_the_others_as_silence_alone():
    """While its radio would be silent anyway, what others are told and see is the same with a stop and without one."""
    radio = {"model": "disc", "range": 6.0}
    silent = {"radio_hazard": 0.999, "radio_outage": 1000}
    goes_on, stops = (in_corridor((1, 5, 9), radio, **silent, stops=stops) for stops in ((), ((1, 4),)))
    for world in (goes_on, stops):
        assert world.briefing(0, 0).scenario == goes_on.briefing(0, 0).scenario
        assert len(world.view(0, 0).mates) == 2
    for _ in range(8):
        for world in (goes_on, stops):
            world.step(np.array([[STAY, STAY, RIGHT]]))
        for agent in (0, 2):
            one, other = goes_on.view(0, agent), stops.view(0, agent)
            assert np.array_equal(one.belief, other.belief)
            assert (one.cell, one.legal.tolist(), one.mates) == (other.cell, other.legal.tolist(), other.mates)
    assert stops.state.end[0, 1] == End.STOPPED
    assert goes_on.state.end[0, 1] == End.FLYING


def test_only_privileged_policies_are_told_who_will_stop():
    world = in_corridor((0, 4), stops=((1, 2),))
    assert world.briefing(0, 0).scenario.failures.stops == ()
    assert world.briefing(0, 0, privileged=True).scenario.failures.stops == ((1, 2),)


def test_uavs_stop_at_the_rate_of_their_hazard_and_whatever_they_do():
    settings = {"failures.hazard": 0.02, "on_collision": "block"}
    task = scenario("thesis-team-4").for_evaluation().with_settings(settings)
    lives = []
    for action in (STAY, RIGHT):
        world = World(task, 200)
        world.reset(range(200))
        for _ in range(100):
            world.step(np.full((200, 4), action))
        lives.append(world.state.end == End.STOPPED)
    assert np.array_equal(*lives)
    assert abs(lives[0].mean() - (1 - 0.98**100)) < 0.03
    assert abs(np.corrcoef(lives[0].T) - np.eye(4)).max() < 0.25


def test_a_failed_radio_neither_sends_nor_receives_for_its_outage():
    world = in_corridor((0, 1), {"model": "unlimited"}, radio_hazard=0.1, radio_outage=5)
    linked, silent = [], []
    for _ in range(4000):
        stay(world)
        linked.append(bool(world.state.linked[0, 0, 1]))
        silent.append((world.state.step[0] < world.state.silent_until[0]).tolist())
    silent = np.array(silent)
    assert (np.array(linked) == ~silent.any(axis=1)).all()
    assert abs(silent.mean() - 5 / (5 + 9)) < 0.04  # nine steps until a failure, then five of silence
    runs = np.diff(np.flatnonzero(np.diff(np.concatenate(([0], silent[:, 0], [0])).astype(int))))[::2]
    assert (runs[:-1] % 5 == 0).all()
