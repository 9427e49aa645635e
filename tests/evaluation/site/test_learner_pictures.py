"""The views that the pictures of learners show are what the pages say of them."""

import numpy as np
import pytest

from indoor_explorers.evaluation.site.pictures import clusters as cluster_pictures
from indoor_explorers.evaluation.site.pictures.learners import moment


def test_network_and_rule_choose_other_moves_in_the_view_that_is_shown():
    assert moment().q.argmax() != moment().rule.argmax()


def test_the_parts_of_the_values_add_up():
    q, advantage = moment().q, np.sum(moment().terms, axis=0)
    assert q - q.mean() == pytest.approx(advantage - advantage.mean(), abs=1e-5)


def test_network_and_planner_choose_other_places_in_the_view_that_is_shown():
    ours, planners = cluster_pictures.choice().goals
    assert ours != planners
