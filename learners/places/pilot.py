"""The pilot that flies to the place of highest value, unless it values an option beside the places more."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell, Mask
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.learners.places.network import Loaded, values
from indoor_explorers.learners.places.options import Option, Options, no_options
from indoor_explorers.learners.places.scene import OTHERS, Observer, Scene
from indoor_explorers.planners.toolbox.information.lookouts import LookoutPilot
from indoor_explorers.planners.toolbox.pockets.estimates import DEFAULT_FILES, EstimateFiles

#: A goal is kept for this many lidar ranges of flight, unless it has no gain left before.
KEEP = 1.0


def leave(worth: NDArray[np.float32], left: Mask) -> None:
    """Leave only some of the K places in their values and those of options, (K + O,), unless there would be none.

    They get the value of the best place, the others -inf; ``left`` (K,) tells which they are.
    """
    of_places = worth[: len(left)]
    if left.any():
        of_places[:] = np.where(left, of_places.max(), -np.inf)


class PlacesPilot(LookoutPilot):
    """Choose among the places, and fly to the one of highest value.

    Args:
        briefing: Briefing of the UAV.
        loaded: The network.
        sector: Preference for the own sector while teammates were never heard.
        files: Files of the estimates' weights.

    """

    changes_levels: ClassVar[bool] = True
    straight = True

    def __init__(
        self, briefing: Briefing, loaded: Loaded, sector: float = 0.0, files: EstimateFiles = DEFAULT_FILES
    ) -> None:
        super().__init__(briefing)
        self._loaded = loaded
        self._observer = Observer(
            self, guess=loaded.guess, lookouts=loaded.lookouts, task=loaded.task, sector=sector, files=files
        )
        self.lookouts = self._observer.lookouts
        self.replan_period = self.steps_in(KEEP)
        self.values_options = loaded.options
        """Whether the network values options beside the places."""
        self._observe_options: list[Callable[[Options], None]] = []
        self._taken: Option | None = None
        self._keeps_place, self._next_options = False, 0.0
        self._beyond = ""

    def choose_among(self, observe: Callable[[Options], None]) -> None:
        """Choose among the options too that ``observe`` tells at a choice.

        Where the map has not grown, they alone are chosen among, or the UAV flies on.
        """
        self._observe_options.append(observe)

    def take_option(self, *among: Option) -> Option | None:
        """Return which of some options this step's choice preferred to all places, only once; None if it did not."""
        if self._taken not in among:
            return None
        taken, self._taken = self._taken, None
        return taken

    def choose_soon(self) -> None:
        """Choose among the options at the next step, although the last choice was less than a lidar range ago."""
        self._next_options = 0.0

    def wants_replan(self, view: View) -> bool:
        """Tell whether to choose again although the goal is still useful; options also where the map has not grown."""
        return super().wants_replan(view) or (bool(self._observe_options) and view.step >= self._next_options)

    def choose_goal(self, view: View) -> None:
        """Choose a goal; the present one is kept if it is only time to choose among the options."""
        grew, due, goal = self._grew_since_choice, self._next_choice, self.goal
        self._keeps_place = bool(self._observe_options) and goal is not None and not self._is_place_due(view, goal)
        keeps = self._keeps_place
        super().choose_goal(view)
        self._next_options = view.step + self.replan_period
        if keeps and self.goal == goal:
            self._grew_since_choice, self._next_choice = grew, due

    def _is_place_due(self, view: View, goal: Cell) -> bool:
        return super().wants_replan(view) or self.is_spent(view, goal) or self.navigator.is_overdue(view)

    def choose(self, view: View) -> Cell | None:
        """Return the place of highest value."""
        self._taken = None
        keeps, self._keeps_place = self._keeps_place, False
        scene = self._observer.observe(view)
        if scene is None:
            return None
        if not self._loaded.others:
            scene.places[:, OTHERS] = 0.0
        if self.values_options:
            options = no_options()
            for observe in self._observe_options:
                observe(options)
            scene = scene.with_options(options)
        worth, goal = values(scene, self._loaded), self.goal
        if keeps and goal is not None:
            leave(worth, scene.cells == goal[0] * self.paths.width + goal[1])
        row = self.pick(view, scene, worth)
        if row >= len(scene.cells):
            self._taken = Option(row - len(scene.cells))
            row = int(worth[: len(scene.cells)].argmax())
        return divmod(int(scene.cells[row]), self.paths.width)

    def pick(self, view: View, scene: Scene, worth: NDArray[np.float32]) -> int:
        """Return the number of the chosen place, or that of an option behind all places; ``worth`` (K + O,)."""
        if self.explaining:
            of_places = worth[: len(scene.cells)]
            self.consider(
                scene.cells,
                "network, less the weighted cost to frontier-predictive",
                of_places,
                network=of_places + self._loaded.prior * scene.costs,
                cost=scene.costs,
                steps=scene.steps * self.briefing.lidar_range,
            )
            beyond = zip(Option, worth[len(scene.cells) :] - of_places.max(), strict=False)
            self._beyond = ", ".join(f"{each.name.lower()} {value:.2f}" for each, value in beyond if value > -np.inf)
        return int(worth.argmax())

    def note_on_choice(self) -> str:
        """Return the values of the options at the latest choice beyond that of the best place."""
        return self._beyond and f"beyond the best place: {self._beyond}"
