from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env.sensing.lidar import view_gain
from indoor_explorers.planners.frontier.utility import Form, FrontierUtility
from tests.planners.flights import view_of

from .test_group_pilot import pilot_of

BELIEF = np.array(
    [
        [0, 0, 0, 0, 0, 0, 0, 0, 0],
        [0, 0, 0, 0, 0, 0, 0, 0, 0],
        [1, 1, 1, 1, 1, 1, 1, 1, 1],
        [2, 2, 2, 2, 2, 1, 2, 2, 2],
        [2, 2, 2, 2, 2, 1, 0, 2, 2],
    ],
    np.uint8,
)


@pytest.mark.parametrize("form", ["size", "difference", "discounted"])
def test_scores_are_the_formulas(form: Form) -> None:
    pilot = pilot_of(FrontierUtility(form=form, cost=0.5), 0, (5, 9))
    view, reach = view_of(BELIEF, (3, 5)), 3.0
    choices = pilot.choices(view, pilot.members(view))
    gains, steps = pilot.gains(view, choices), choices.steps.astype(np.float64)
    if form == "size":
        assert sorted(gains.tolist()) == sorted(np.diff(choices.clusters.ends).tolist()) == [1, 2, 3, 4]
        expected = gains - 0.5 * steps
    else:
        cells = [divmod(cell, 9) for cell in choices.viewpoints().tolist()]
        assert gains.tolist() == [view_gain(BELIEF, cell, reach) for cell in cells]
        expected = gains - 0.5 * reach * steps if form == "difference" else gains * np.exp(-0.5 * steps / reach)
    np.testing.assert_allclose(pilot.score(gains, steps), expected)


def test_the_weight_of_the_path_decides_between_large_and_near() -> None:
    goals = []
    for cost in (0.01, 100.0):
        pilot = pilot_of(FrontierUtility(form="discounted", cost=cost), 0, (5, 9))
        pilot.act(view_of(BELIEF, (3, 5)))
        goals.append(pilot.goal)
    assert goals[0] is not None
    assert goals[0][0] == 2
    assert goals[1] in {(4, 5), (2, 5)}
