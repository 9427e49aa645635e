"""What the configurations of all learners have in common."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from indoor_explorers.env.scenarios.scenario import Scenario


class Settings(BaseModel):
    """Settings that a user may set: frozen, without unknown keys, each described by the sentence below it."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True)


class LearnerSettings(Settings):
    """The hyperparameters of one training."""

    evaluation_every: int = Field(ge=1)
    """Moves, or another unit of the learner's, between two evaluations."""
    checkpoint_every: int = Field(ge=1)
    """The same between two checkpoints."""

    def task(self, scenario: Scenario) -> Scenario:
        """Return the scenario as it is trained on, with the training's goal and rewards."""
        raise NotImplementedError

    def tasks(self, scenario: Scenario) -> list[Scenario]:
        """Return all scenarios that are trained on side by side."""
        return [self.task(scenario)]
