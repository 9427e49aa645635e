"""The pilot that flies to the place of highest value."""

from __future__ import annotations

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.learners.places.network import Loaded, values
from indoor_explorers.learners.places.scene import OTHERS, Observer, Scene
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot

#: A goal is kept for this many lidar ranges of flight, unless it has no gain left before.
KEEP = 1.0


class PlacesPilot(GoalPilot):
    """Choose among the places, and fly to the one of highest value.

    Args:
        briefing: Briefing of the UAV.
        loaded: The network.

    """

    straight = True

    def __init__(self, briefing: Briefing, loaded: Loaded) -> None:
        super().__init__(briefing)
        self._loaded = loaded
        self._observer = Observer(self, guess=loaded.guess)
        self.replan_period = self.steps_in(KEEP)

    def choose(self, view: View) -> Cell | None:
        """Return the place of highest value."""
        scene = self._observer.observe(view)
        if scene is None:
            return None
        if not self._loaded.others:
            scene.places[:, OTHERS] = 0.0
        return divmod(int(scene.cells[self.pick(view, scene)]), self.paths.width)

    def pick(self, view: View, scene: Scene) -> int:
        """Return the number of the chosen place."""
        return int(values(scene, self._loaded).argmax())
