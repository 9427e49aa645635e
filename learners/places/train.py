"""The dueling network that chooses places, among frontier clusters, on maps of any size.

A training is a session around :class:`indoor_explorers.learners.places.training.PlacesTraining`. It draws its own maps
and tasks, so it takes no scenario. The folder gets ``places.safetensors`` (the mean of the later rounds' networks),
``training.json`` (configuration, seed, versions, commits, figures of each round), ``checkpoint.safetensors``
(everything that a resumed training needs, beside the flights of the present round in ``flights/``) and
``tensorboard/``. The same seed gives the same weights, resumed or not.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

from indoor_explorers.learners.places.policy import NAME
from indoor_explorers.learners.places.training import PlacesTraining, TrainingConfig
from indoor_explorers.learners.pockets.maps import map_record
from indoor_explorers.learners.sessions.session import Session
from indoor_explorers.learners.sessions.tensorboard import Scalars
from indoor_explorers.learners.sessions.train import TrainingMethod

__all__ = ["DEFAULT_SCENARIO", "TrainingConfig", "train"]

#: There is none: each flight draws its map, lidar, team and radio.
DEFAULT_SCENARIO = None


@contextmanager
def _trainee(config: TrainingConfig, scenario: None, seed: int, session: Session) -> Iterator[PlacesTraining]:
    with Scalars(session):
        yield PlacesTraining(config, seed, session.out, session.checkpoint)


train = TrainingMethod(partial(map_record, "dddqn-places"), _trainee, weights=NAME)
