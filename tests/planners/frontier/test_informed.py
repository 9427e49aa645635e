from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from indoor_explorers.env import InputError, make_policy
from indoor_explorers.planners.frontier.informed import SUPPOSED, FrontierInformed
from indoor_explorers.planners.toolbox.frontiers.clusters import frontier_clusters
from tests.planners.flights import world_on

SPEC = "indoor_explorers.planners.frontier.informed:FrontierInformed"
#: A room, known, with doors to a large one in the east and to a niche in the west.
TRUTH = np.full((9, 24), 2, np.uint8)
TRUTH[1:8, 4:11] = TRUTH[1:8, 12:23] = 1
TRUTH[4, 2:12] = 1


def pilot_of(policy: FrontierInformed, *, privileged: bool = True) -> Any:
    return policy.pilot(world_on(TRUTH == 1, [(4, 7)], lidar__range=10.0).briefing(0, 0, privileged=privileged))


def told(policy: FrontierInformed) -> list[float]:
    belief = np.where((np.arange(24) > 2) & (np.arange(24) < 12), TRUTH, 0).astype(np.uint8)
    clusters = frontier_clusters(belief, 10.0)
    assert (clusters.cells % 24).tolist() == [3, 11]
    return [float(size) for size in pilot_of(policy).reported(np.array([2.0, 0.0]), clusters)]


def test_true_sizes_are_told_unless_they_are_to_be_wrong() -> None:
    assert told(FrontierInformed()) == [2.0, 0.0]
    assert told(FrontierInformed(mistaken=1.0)) == [0.0, SUPPOSED]
    wrong = told(FrontierInformed(error=1.0))
    assert wrong[0] not in (0.0, 2.0)
    assert wrong[1] == 0.0


def test_it_needs_the_true_map() -> None:
    with pytest.raises(InputError, match="expected a briefing with the true map"):
        pilot_of(FrontierInformed(), privileged=False)
    assert make_policy(SPEC).privileged
