"""The base classes of all learners' configurations."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from indoor_explorers.env.scenarios.scenario import Scenario


class Settings(BaseModel):
    """Settings that a user may set: frozen, without unknown keys, each described by the sentence below it."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True)


class LearnerSettings(Settings):
    """The hyperparameters of one training."""

    evaluation_every: int = Field(ge=1)
    """Moves between two evaluations; some learners count episodes."""
    checkpoint_every: int = Field(ge=1)
    """Moves or episodes between two checkpoints."""

    def task(self, scenario: Scenario) -> Scenario:
        """Return a scenario with the goal and the rewards of the training."""
        raise NotImplementedError

    def tasks(self, scenario: Scenario) -> list[Scenario]:
        """Return all scenarios that the learner trains on at the same time."""
        return [self.task(scenario)]
