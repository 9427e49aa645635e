"""Goals: whatever a planner changes its mind to, its UAV gets somewhere."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest

from indoor_explorers.env import FREE, OCCUPIED, PRESETS, UNKNOWN, Action, make_policy
from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.sensing.inverse_model import HIT
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot
from indoor_explorers.planners.toolbox.navigation.navigator import Navigator
from tests.planners.flights import fly


class Fickle(GoalPilot):
    """Prefer the frontier on the other side at every step."""

    def wants_replan(self, view: View) -> bool:
        return True

    def choose(self, view: View) -> Cell | None:
        known = np.flatnonzero(view.belief[1] == 1)
        ends = [end for end in ((1, int(known[0])), (1, int(known[-1]))) if not self.is_spent(view, end)]
        return ends[view.step % len(ends)] if ends else None


class FicklePolicy(Policy):
    def pilot(self, briefing: Briefing) -> Pilot:
        return Fickle(briefing)


def test_who_keeps_changing_its_mind_gets_somewhere() -> None:
    free = np.zeros((3, 30), np.bool_)
    free[1, 1:-1] = True
    flight = fly(FicklePolicy(), free, spawns=[(1, 15)])
    assert flight.complete
    assert 2 <= flight.longest_dither <= 6


class Settled(GoalPilot):
    """Prefer the frontier on the left."""

    def choose(self, view: View) -> Cell | None:
        return (1, int(np.flatnonzero(view.belief[1] == FREE)[0]))


def corridor(known: slice) -> View:
    """A UAV in the middle of a corridor of 30 cells."""
    belief = np.full((3, 30), OCCUPIED, np.uint8)
    belief[1, 1:-1] = UNKNOWN
    belief[1, known] = FREE
    return View(belief, (1, 15), np.array([False, False, True, True, True]), 0, 100, (), belief == FREE)


@pytest.mark.parametrize(("period", "chosen"), [(inf, [0]), (0, [0, 1, 2, 4]), (3, [0, 3])])
def test_a_goal_is_chosen_again_when_the_map_has_grown_and_the_period_is_over(period: float, chosen: list[int]) -> None:
    pilot = Settled(briefing_of((3, 30)))
    pilot.replan_period = period
    found = []
    for step, end in enumerate([17, 18, 19, 19, 20]):
        plans = pilot.plans
        pilot.act(corridor(slice(10, end))._replace(step=step, cell=(1, 15 - step)))
        if pilot.plans > plans:
            found.append(step)
    assert found == chosen


def test_nearness_to_a_goal_is_by_straight_lines_or_by_rows_and_columns() -> None:
    pilot = Settled(briefing_of((9, 9)))
    cells = np.array([4 * 9 + 4, 4 * 9 + 6, 6 * 9 + 6], np.int32)
    assert pilot.near_goal((4, 4), cells, 2.0).tolist() == [True, True, False]
    assert pilot.near_goal((4, 4), cells, 2.0, np.maximum).tolist() == [True, True, True]
    assert pilot.near_goal(None, cells, 2.0).tolist() == [False, False, False]


def briefing_of(shape: tuple[int, int]) -> Briefing:
    scenario = PRESETS["thesis-open"]
    return Briefing(agent=0, team=1, shape=shape, lidar_range=3.0, scenario=scenario, rng=np.random.default_rng(0))


@pytest.mark.parametrize(("readings", "goes"), [(None, False), (2, True), (60, True), (70, False)])
def test_obstacles_that_few_readings_speak_for_are_looked_at_where_nothing_else_is_left(readings, goes) -> None:
    belief = np.full((3, 9), OCCUPIED)
    belief[1, 1:4], belief[1, 5:8] = FREE, UNKNOWN  # and an obstacle between
    log_odds = None if readings is None else np.where(belief == OCCUPIED, np.float32(100.0) * HIT, -HIT)
    if log_odds is not None:
        log_odds[1, 4] = readings * HIT
    pilot = make_policy("frontier-nearest").pilot(briefing_of((3, 9)))
    legal = np.array([False, False, False, True, True])
    view = View(belief, (1, 1), legal, 0, 100, (), belief == FREE, log_odds=log_odds)
    assert pilot.act(view) == (Action.RIGHT if goes else Action.STAY)
    assert pilot.done == (not goes)


@pytest.mark.parametrize(("former", "present"), [("swings", "oscillates"), ("stands", "is_stationary")])
def test_former_names_of_a_navigators_attributes_are_answered_with_a_warning(former: str, present: str) -> None:
    navigator = Navigator(briefing_of((3, 9)))
    navigator.recent.extend([(1, 1), (1, 2), (1, 1), (1, 2)])
    with pytest.warns(FutureWarning, match=f"{former} is now {present}"):
        assert getattr(navigator, former) is getattr(navigator, present)
