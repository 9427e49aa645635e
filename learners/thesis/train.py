"""The DDDQN of the IndoorExplorers thesis, with its mistakes as switches.

A training is a session around :class:`indoor_explorers.learners.thesis.training.ThesisTraining`.
The folder gets ``weights.safetensors`` (the latest network, as in the thesis), ``episodes.csv`` (every training
episode: the thesis's curve), ``training.json`` (configuration, seed, versions, commits, evaluations) and
``checkpoint.safetensors`` (everything that a resumed training needs). The same seed gives the same weights, resumed
or not.
"""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from functools import partial

from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.sessions.record import new_record
from indoor_explorers.learners.sessions.session import Session
from indoor_explorers.learners.sessions.train import TrainingMethod
from indoor_explorers.learners.thesis.config import MENDED, TrainingConfig
from indoor_explorers.learners.thesis.training import ThesisTraining

__all__ = ["MENDED", "TrainingConfig", "train"]


def _trainee(
    config: TrainingConfig, scenario: Scenario, seed: int, session: Session
) -> AbstractContextManager[ThesisTraining]:
    return nullcontext(ThesisTraining(config, scenario, seed, session.checkpoint))


train = TrainingMethod(partial(new_record, "dddqn-thesis"), _trainee)
