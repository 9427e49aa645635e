"""Flights home: in time, as planned, by the UAV that is nearest, and with the explorer's flights in between."""

import numpy as np
import pytest

from indoor_explorers.env import InputError, Pilot, make_policy
from indoor_explorers.planners.return_to_base import ReturnToBase
from tests.planners.flights import fly_preset

HOME = {"base.at": "start", "base.must_return": True}


def flown(policy, name="small-offices", seed=3, **settings):
    """The world after an episode, and its pilots."""
    return fly_preset(policy, name, seed, **({"budget": 150} | settings))


@pytest.mark.parametrize("when", ["deadline", "every", "trips", "worth"])
@pytest.mark.parametrize(("seed", "budget"), [(1, 60), (2, 97), (3, 150), (4, 300)])
def test_a_uav_is_home_in_time(when, seed, budget):
    world, pilots, _ = flown(ReturnToBase(when=when), seed=seed, budget=budget, **HOME)
    assert world.base_coverage[0] == world.team_coverage[0] > 0.1
    assert pilots[0, 0].tally()["flights_home"] >= 1


@pytest.mark.parametrize("explorer", ["frontier", "frontier-minpos", "pso"])
@pytest.mark.parametrize("settings", [{}, {"base.at": "start"}], ids=["no base", "never"])
def test_without_flights_home_it_is_the_explorer(explorer, settings):
    alone = flown(make_policy(explorer), team=3, **settings)[2]
    found = flown(ReturnToBase(explorer=explorer, when="never" if settings else "trips"), team=3, **settings)[2]
    assert np.array_equal(found, alone)


def test_it_declares_what_its_explorer_was_trained_with():
    learner, alone = ReturnToBase(explorer="dddqn-places"), make_policy("dddqn-places")
    assert learner.provenance() == alone.provenance() != {}
    assert learner.seen_maps() == alone.seen_maps() != {}
    assert ReturnToBase(explorer="dddqn").seen_seeds() == make_policy("dddqn").seen_seeds() != {}
    assert ReturnToBase().provenance() == {}


def test_fixed_intervals_are_kept():
    world, pilots, _ = flown(ReturnToBase(when="every", every=30), budget=400, **HOME)
    contacts = pilots[0, 0].tally()["flights_home"]
    assert 3 <= contacts <= 400 / 30
    assert world.base_coverage[0] == world.team_coverage[0]


def test_the_more_trips_the_later_reports_the_fewer_flights():
    flights = [flown(ReturnToBase(trips=trips), budget=400, **HOME)[1][0, 0].tally() for trips in (0.5, 2.0, 8.0)]
    counts = [each["flights_home"] for each in flights]
    assert counts == sorted(counts, reverse=True)
    assert counts[0] > counts[-1]


def test_a_flight_home_is_made_when_cells_have_waited_for_its_cost_and_time_is_left():
    """Cheap flights are made often; a reserve of time forbids them where the rest would not be explored in time."""
    often, seldom, none = (
        flown(ReturnToBase(when="worth", worth=worth, reserve=reserve), budget=400, **HOME)[1][0, 0].tally()
        for worth, reserve in ((0.1, 0.0), (1.0, 0.0), (0.1, 1e9))
    )
    assert often["flights_home"] > seldom["flights_home"] > none["flights_home"]
    assert none == flown(ReturnToBase(when="deadline"), budget=400, **HOME)[1][0, 0].tally()


def test_known_cells_are_counted_where_poses_drift():
    world, pilots, _ = fly_preset(ReturnToBase(), "small-offices", 3, budget=60, **{"drift.rate": 0.05}, **HOME)
    pilot = pilots[0, 0]
    assert 0 < pilot.reported <= pilot.known <= world.view(0, 0).belief.size


def test_of_uavs_in_contact_the_nearest_flies_home():
    policy = ReturnToBase(when="every", every=25)
    world, pilots, _ = flown(policy, team=3, budget=300, **HOME, **{"radio.model": "unlimited"})
    assert world.base_coverage[0] == 1.0  # always in contact with the base: nobody has to fly there
    assert sum(pilots[0, n].tally()["flights_home"] for n in range(3)) == 0
    world, pilots, _ = flown(policy, team=3, budget=300, **HOME)
    assert sum(pilots[0, n].tally()["handed_over"] for n in range(3)) > 0
    assert world.base_coverage[0] > 0.9 * world.team_coverage[0]


def test_teammates_messages_reach_the_explorer_as_it_sent_them(monkeypatch):
    heard, sent = [], []
    explorer = type(make_policy("frontier"))

    class Listening(Pilot):
        def __init__(self, briefing):
            self.rng = briefing.rng

        def act(self, view):
            heard.extend(mate.message for mate in view.mates if mate.age == 0)
            self.message = (float(view.step), 7.0) if view.step % 2 else None
            sent.append(self.message)
            return int(self.rng.choice(np.flatnonzero(view.legal)))

    monkeypatch.setattr(explorer, "pilot", lambda self, briefing: Listening(briefing))
    flown(ReturnToBase(), team=2, budget=30, **HOME, **{"radio.model": "unlimited"})
    assert {None, (1.0, 7.0)} <= set(heard) <= set(sent)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"explorer": 3}, "expected the name of a policy as explorer, got 3"),
        ({"explorer": "reference"}, "expected an explorer that is not given the map, got 'reference'"),
        ({"explorer": "frontir"}, "did you mean 'frontier'"),
    ],
)
def test_an_explorer_that_does_not_fit_is_refused(parameters, message):
    with pytest.raises(InputError, match=message):
        ReturnToBase(**parameters)


def test_it_declares_what_its_explorer_reads():
    assert ReturnToBase(explorer="dddqn").uses_generator
    assert not ReturnToBase().uses_generator
