"""Policies that declare to be done: when, and what stopping then would have cost and saved."""

from dataclasses import dataclass

import pytest

from indoor_explorers.env import Pilot, Policy, make_policy, scenario
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task


class Declaring(Pilot):
    """Fly to the nearest frontier and declare to be done from a step on, for a while."""

    def __init__(self, briefing, first, last):
        self._pilot = make_policy("frontier-nearest").pilot(briefing)
        self._steps = range(first + briefing.agent, last)

    def act(self, view):
        self.done = view.step in self._steps
        return self._pilot.act(view)


@dataclass(frozen=True, kw_only=True)
class Declares(Policy):
    first: int = 5
    last: int = 12

    def pilot(self, briefing):
        return Declaring(briefing, self.first, self.last)


def flown(policy, name="thesis-team-2", seeds=(1, 2), **settings):
    task = scenario(name).for_evaluation().with_settings({"on_collision": "block"} | settings)
    return list(fly(policy, "declares", task, [Task(task.name, 0, seed) for seed in seeds]))


@pytest.mark.parametrize("team", [1, 2, 4])
def test_the_mission_is_over_when_all_uavs_say_so(team):
    for record in flown(Declares(), team=team):
        done = 5 + team - 1
        assert record.metrics["done_step"] == done
        assert record.metrics["done_coverage"] == record.curve[done] < 1.0
        assert record.metrics["done_lost"] == pytest.approx(1.0 - record.curve[done])
        assert record.metrics["done_saved"] == record.steps - done > 0


def test_where_not_all_ever_do_nothing_is_told():
    for record in flown(Declares(first=5, last=6), team=2):
        assert not any(name.startswith("done_") for name in record.metrics)


@dataclass(frozen=True, kw_only=True)
class Breaks(Declares):
    def act(self, pilots, views):
        actions = super().act(pilots, views)
        if views[0].step == 3:
            raise ValueError("broken")
        return actions


def test_a_failure_declares_nothing():
    for record in flown(Breaks(), team=2):
        assert record.reason.startswith("ValueError: broken")
        assert not any(name.startswith("done_") for name in record.metrics)


def test_it_changes_no_flight():
    for one, other in zip(flown(Declares()), flown(make_policy("frontier-nearest")), strict=True):
        assert one.flew_like(other)


def test_a_planner_is_done_when_nothing_is_left_to_fly_to():
    for record in flown(make_policy("frontier-nearest"), team=1, budget=400, goal=1.0, denominator="reachable"):
        assert record.metrics.get("done_step", record.steps) >= record.steps - 1


def test_the_planner_that_estimates_declares_when_it_expects_enough():
    record, *_ = flown(make_policy("frontier-predictive"), "floors", seeds=(5,), team=1)
    assert record.metrics["done_saved"] > 100
    assert record.metrics["done_coverage"] > 0.97
    (never,) = flown(make_policy("frontier-predictive", aim=1.0), "floors", seeds=(5,), team=1, goal=0.999)
    assert never.metrics.get("done_step", never.steps) > record.metrics["done_step"]
