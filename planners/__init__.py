"""Classical planners, frontier-based, sampling-based and swarm, and the building blocks for a new one.

Subclass :class:`GoalPilot` and write ``choose``, which returns the frontier cell to fly to next: the pilot keeps the
goal, flies to it and resolves deadlocks. :func:`frontier_clusters` and :func:`nearest_cells` give the candidates,
:class:`WeightedGains` and :func:`unclaimed_gains` the view gain of a scan there, and :class:`Paths` finds paths.
"""

from typing import TYPE_CHECKING

from indoor_explorers.env.lazy_names import lazy_names

if TYPE_CHECKING:
    from indoor_explorers.planners.toolbox.frontiers.clusters import Clusters, frontier_clusters, nearest_cells
    from indoor_explorers.planners.toolbox.information.view_gain import WeightedGains, unclaimed_gains
    from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot
    from indoor_explorers.planners.toolbox.navigation.navigator import Navigator
    from indoor_explorers.planners.toolbox.navigation.paths import Paths

__all__ = [
    "Clusters",
    "GoalPilot",
    "Navigator",
    "Paths",
    "WeightedGains",
    "frontier_clusters",
    "nearest_cells",
    "unclaimed_gains",
]

#: The modules of the public names.
_MODULES = {
    "toolbox.frontiers.clusters": ("Clusters", "frontier_clusters", "nearest_cells"),
    "toolbox.information.view_gain": ("WeightedGains", "unclaimed_gains"),
    "toolbox.navigation.goal_pilot": ("GoalPilot",),
    "toolbox.navigation.navigator": ("Navigator",),
    "toolbox.navigation.paths": ("Paths",),
}
__getattr__ = lazy_names(__name__, _MODULES)


def __dir__() -> list[str]:
    return [*globals(), *__all__]
