"""Trainings of a study in the test's own process."""

from __future__ import annotations

import pytest

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.studies import many_trainings
from indoor_explorers.evaluation.studies.many_trainings import Failure, Training, run


class Inline:
    """A training in this process, which is over as soon as it began."""

    over = True

    def __init__(self, training: Training, *, shown: bool) -> None:
        self.training, self.reason = training, None
        try:
            run(training)
        except InputError as error:
            self.reason = str(error)

    def failure(self) -> Failure | None:
        return None if self.reason is None else Failure(self.training, self.reason)


def inline(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(many_trainings, "TrainingProcess", Inline)
    patch.setattr(many_trainings, "CHECK_INTERVAL", 0.0)
