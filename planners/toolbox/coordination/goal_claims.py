"""Places that linked teammates fly to: how many of their goals are near each place.

A planner that values places one by one lowers the value of those that a teammate will see in any case.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.policies.view import View
from indoor_explorers.planners.toolbox.navigation.teammates import linked, told_goal


def goals_near(view: View, points: NDArray[np.float64], radius: float) -> NDArray[np.int64]:
    """Return the number of linked teammates' goals within ``radius`` cells of each of (K, 2) rows and columns, (K,)."""
    told = [goal for mate in linked(view) if (goal := told_goal(mate)) is not None]
    goals = np.array(told, np.float64).reshape(-1, 2)
    away = np.hypot(*(points[:, None, :] - goals[None, :, :]).transpose(2, 0, 1))
    return np.asarray((away <= radius).sum(axis=1))
