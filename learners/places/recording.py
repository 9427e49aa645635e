"""What training flights record: each choice with the true map, made at random by the network's values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.learners.places.network import Loaded
from indoor_explorers.learners.places.option_pilots import with_options
from indoor_explorers.learners.places.pilot import PlacesPilot, leave
from indoor_explorers.learners.places.scene import Scene
from indoor_explorers.learners.places.truth import TrueMap, Truth, truth_of
from indoor_explorers.planners.toolbox.navigation.paths import count_known
from indoor_explorers.planners.toolbox.pockets.estimates import EstimateFiles


class Choice(NamedTuple):
    """One choice of a flight."""

    scene: Scene
    """The K places that it was made among."""
    truth: Truth
    """The features of the true map at these places."""
    chosen: int
    """Row of the chosen place, or K and the number of the chosen option."""
    step: int
    """Step of the flight."""
    known: int
    """Cells that the UAV knew."""
    probabilities: NDArray[np.float32]
    """(K,) with which each place was drawn, or (K + O,) with options."""


class Recording(NamedTuple):
    """The true map, the generator and the choices of a flight, which its pilots share."""

    true: TrueMap
    rng: np.random.Generator
    choices: dict[int, list[Choice]]
    """The choices so far, by UAV."""
    options_alone: bool = False
    """Whether options are drawn alone: of the places the best one is flown to."""


@dataclass(frozen=True, kw_only=True)
class Recorder(Policy):
    """The policy of a training flight."""

    loaded: Loaded
    recording: Recording
    files: EstimateFiles
    late_cost: float

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        pilot = RecordingPilot(briefing, self.loaded, self.recording, self.files)
        return with_options(pilot, self, self.files, self.late_cost)


class RecordingPilot(PlacesPilot):
    """Choose at random, with probabilities that grow with the values, and record the choice with the truth."""

    def __init__(self, briefing: Briefing, loaded: Loaded, recording: Recording, files: EstimateFiles) -> None:
        super().__init__(briefing, loaded, files=files)
        self._recording = recording

    def pick(self, view: View, scene: Scene, worth: NDArray[np.float32]) -> int:
        """Return the row of the drawn place or option; the probabilities are the softmax of the values."""
        recording, reach = self._recording, float(self.briefing.lidar_range)
        if recording.options_alone:
            count = len(scene.cells)
            leave(worth, np.arange(count) == worth[:count].argmax())
        logits = worth.astype(np.float64)
        probabilities = np.exp(logits - logits.max())
        probabilities /= probabilities.sum()
        chosen = int(recording.rng.choice(len(probabilities), p=probabilities))
        field = self.steps_from(view, view.cell)
        truth = truth_of(scene, self.clusters(view), view.belief, recording.true, field, reach)
        known = count_known(view.belief)
        choice = Choice(scene, truth, chosen, view.step, known, probabilities.astype(np.float32))
        recording.choices.setdefault(self.briefing.agent, []).append(choice)
        return chosen
