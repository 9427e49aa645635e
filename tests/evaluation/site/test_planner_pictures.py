"""The pictures of the page on planners show what the planners decide."""

import pytest

from indoor_explorers.evaluation.site.pictures import planner_teams, planner_views
from indoor_explorers.evaluation.site.pictures import planners as pictures


@pytest.mark.parametrize("name", ["frontier-latency", "frontier"])
def test_the_first_place_of_a_plan_is_the_goal(name):
    pilot, view = planner_views.pilot_at(name, planner_views.DECISIONS)
    first, *others = pictures._planned(pilot, view)
    pilot.act(view)
    assert pilot.goal == first
    assert others


def test_a_joint_plan_leads_to_the_goals_of_the_uavs():
    joint, view = planner_teams.joint_plan()
    first = [planner_views.cell_of(joint.cells[k], view) for k in joint.best[:, 0]]
    assert len(joint.members) == len(set(first)) == 2
    assert len(joint.initial) == len(planner_teams.INITIAL)
