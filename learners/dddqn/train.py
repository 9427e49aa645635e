"""The dueling double deep Q-network (DDDQN) of this project.

A training is a session around :class:`indoor_explorers.learners.dddqn.learning.training.Training`.
The folder gets ``weights.safetensors`` (the averaged weights that did best in evaluation), ``training.json``
(configuration, seed, versions, commits, evaluations), ``checkpoint.safetensors`` (everything that a resumed training
needs) and ``tensorboard/``. The same seed gives the same weights, resumed or not.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.dddqn.config import TrainingConfig
from indoor_explorers.learners.dddqn.learning.training import Training
from indoor_explorers.learners.dddqn.presets import ABLATION_SETTINGS, ABLATIONS, PRESETS, TEAM_ABLATIONS, flown
from indoor_explorers.learners.sessions.record import new_record
from indoor_explorers.learners.sessions.session import Progress, Session
from indoor_explorers.learners.sessions.tensorboard import Scalars
from indoor_explorers.learners.sessions.train import TrainingMethod

__all__ = [
    "ABLATIONS",
    "ABLATION_SETTINGS",
    "PRESETS",
    "TEAM_ABLATIONS",
    "Progress",
    "TrainingConfig",
    "flown",
    "train",
]


@contextmanager
def _trainee(config: TrainingConfig, scenario: Scenario, seed: int, session: Session) -> Iterator[Training]:
    with Scalars(session):
        yield Training(config, scenario, seed, session.checkpoint)


train = TrainingMethod(partial(new_record, "dddqn"), _trainee)
