"""Failure modes: the faults are as described, a policy that does not finish is warned about, and can be seen to."""

import re

import numpy as np
import pytest

from indoor_explorers.env import Pilot, Policy, make_policy, run_checks
from indoor_explorers.env.conformance import FAILURE_MODES, fly_failure_mode
from indoor_explorers.env.conformance import failure_modes as module
from indoor_explorers.env.search.connected_parts import connected_parts
from tests.env.conformance.policies import Honest, make

MODES = {mode.name: mode for mode in FAILURE_MODES}


class Recorded(Policy):
    """Another policy, whose calls are recorded as (UAV, step, number of its pilot, cell, what it heard)."""

    def __init__(self, name="frontier-nearest", says=None):
        self.policy, self.says, self.calls, self.pilots = make_policy(name), says, [], {}

    def pilot(self, briefing):
        number = self.pilots[briefing.agent] = self.pilots.get(briefing.agent, 0) + 1
        return RecordedPilot(self, self.policy.pilot(briefing), briefing.agent, number)

    def of(self, agent):
        return [call for call in self.calls if call[0] == agent]


class RecordedPilot(Pilot):
    def __init__(self, policy, pilot, agent, number):
        self.policy, self.inner, self.agent, self.number = policy, pilot, agent, number

    def act(self, view):
        self.message = self.policy.says
        heard = {mate.agent: mate.message for mate in view.mates}
        self.policy.calls.append((self.agent, view.step, self.number, view.cell, heard))
        return self.inner.act(view)


@pytest.mark.parametrize("mode", FAILURE_MODES, ids=lambda mode: mode.name)
def test_a_stopped_uav_bars_the_way_to_no_other_cell(mode):
    free = mode.rows != "#"
    assert all(free[cell] for cell in mode.spawns)
    _, sizes = connected_parts(free)
    stops = mode.cells("+") or ([mode.spawns[1]] if mode.asked_from >= module.BUDGET else [])
    for stop in stops:
        without = free.copy()
        without[stop] = False
        assert len(connected_parts(without)[1]) == len(sizes)


def test_a_late_starter_is_not_asked_before_it_starts():
    policy = Recorded()
    flight = fly_failure_mode(policy, MODES["late-starter"], radio={"radio.model": "none"})
    first = next(call for call in policy.of(1))
    assert (first[1], first[3]) == (150, MODES["late-starter"].spawns[1])
    assert policy.of(0)[0][1] == 0
    assert flight.finished


def test_a_stalled_uav_is_asked_but_stays_for_good():
    policy = Recorded()
    flight = fly_failure_mode(policy, MODES["stalled-mate"])
    cells = [call[3] for call in policy.of(1)]
    stopped = cells.index(next(cell for cell in cells if cell in MODES["stalled-mate"].cells("+")))
    assert len(cells[stopped:]) > 3
    assert set(cells[stopped:]) == {cells[stopped]}
    assert flight.agent == 0
    assert flight.finished


def test_a_restarted_uav_has_a_new_pilot_and_a_mute_one_is_not_heard():
    policy = Recorded(says=(1.0,))
    fly_failure_mode(policy, MODES["restarted-mate"])
    assert {(call[1] >= 15) + 1 == call[2] for call in policy.of(1)} == {True}
    assert {call[2] for call in policy.of(0)} == {1}
    policy = Recorded(says=(1.0,))
    fly_failure_mode(policy, MODES["mute-mate"])
    assert {call[4][1] for call in policy.of(0)} == {None}
    assert {call[4].get(0) for call in policy.of(1)} == {None, (1.0,)}


def test_the_flight_is_the_same_again_with_its_radio_and_seed():
    flights = [
        fly_failure_mode(make_policy("pso"), MODES["mate-in-doorway"], radio={"radio.model": "none"}, seed=seed)
        for seed in (3, 3, 4)
    ]
    assert flights[0].trace.steps == flights[1].trace.steps != flights[2].trace.steps


class Stays(Honest):
    def act(self, view):
        return 4


def findings(policy):
    return {finding.name: finding for finding in run_checks(policy, ["decisions", "failure modes"])}


def test_who_does_not_finish_passes_with_a_warning_that_says_where_and_how_far_it_came():
    found = findings(make(Stays))["failure modes"]
    assert (found.passed, found.warned, found.error, found.fix) == (True, True, None, "")
    assert found.text.startswith("0 of 9 finished in 500 steps; known in the others: late-starter ")
    assert all(re.search(rf"{name} \d+ %", found.text) for name in MODES)
    found = findings(make_policy("frontier-nearest"))["failure modes"]
    assert (found.passed, found.warned) == (True, False)
    assert found.text.startswith("all 9 finished within ")


def test_a_slow_decision_is_a_warning(monkeypatch):
    monkeypatch.setattr(module, "SLOW", 0.0)
    found = findings(make_policy("frontier-nearest"))["failure modes"]
    assert found.warned
    assert re.search(r"all 9 finished within .*; a decision took 0.0 s in late-starter, 0.0 s in ", found.text)


class Fails(Honest):
    """Fails when a teammate has stayed in a cell for long."""

    def act(self, view):
        if any(mate.age == 0 for mate in view.mates) and view.step == 100:
            raise IndexError("list index out of range")
        return super().act(view)


class Shouts(Honest):
    """Sends a wrong message where the others do not fly."""

    def act(self, view):
        action = super().act(view)
        if view.step == 100:
            self.message = (np.inf,)
        return action


@pytest.mark.parametrize(
    ("kind", "text"),
    [
        (Fails, "act raised IndexError: list index out of range"),
        (Shouts, "expected pilot.message"),
    ],
)
def test_what_breaks_the_contract_in_a_mode_alone_is_a_failure(kind, text):
    found = findings(make(kind))
    assert found["decisions"].passed
    assert not found["failure modes"].passed
    assert found["failure modes"].text.startswith(f"in late-starter, {text}")


def test_a_policy_for_smaller_maps_alone_does_not_fly_them():
    policy = make(Stays)
    object.__setattr__(policy, "map_shape", (10, 12))
    assert findings(policy)["failure modes"].text.startswith("not flown: ")
    object.__setattr__(policy, "map_shape", (20, 24))
    assert "0 of 9 finished" in findings(policy)["failure modes"].text
