"""Graph attention over viewpoints, trained by discrete soft actor-critic (ARiADNE).

A training is a session around :class:`indoor_explorers.learners.attention.training.AttentionTraining`. It draws its own
maps and tasks, so it takes no scenario. The folder gets ``weights.safetensors`` (the policy that did best in
evaluation), ``training.json`` (configuration, seed, versions, commits, evaluations), ``checkpoint.safetensors``
(everything that a resumed training needs) and ``tensorboard/``. The same seed gives the same weights, resumed or not.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

from indoor_explorers.learners.attention.training import AttentionTraining, TrainingConfig
from indoor_explorers.learners.pockets.maps import map_record
from indoor_explorers.learners.sessions.session import Session
from indoor_explorers.learners.sessions.tensorboard import Scalars
from indoor_explorers.learners.sessions.train import TrainingMethod

__all__ = ["DEFAULT_SCENARIO", "TrainingConfig", "train"]

#: There is none: each flight draws its map, lidar, team and radio.
DEFAULT_SCENARIO = None


@contextmanager
def _trainee(config: TrainingConfig, scenario: None, seed: int, session: Session) -> Iterator[AttentionTraining]:
    with Scalars(session):
        yield AttentionTraining(config, seed, session.checkpoint)


train = TrainingMethod(partial(map_record, "attention-sac"), _trainee)
