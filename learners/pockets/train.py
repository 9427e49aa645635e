"""The pocket network, which estimates how much unknown free space is behind each frontier cluster.

A training is a session around :class:`indoor_explorers.learners.pockets.training.PocketTraining`. It flies planners
over maps that it draws, so it takes no scenario. The folder gets ``pockets.safetensors`` (the latest network),
``training.json`` (configuration, seed, versions, commits, loss of each epoch), ``checkpoint.safetensors`` (everything
that a resumed training needs, beside the flights in ``flights/``), ``tensorboard/`` and, with the suite ``floors``,
``validation.md`` (how good the estimates are on its validation part). The same seed gives the same weights, resumed
or not.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

from indoor_explorers.env.scenarios.suites.suite import Part
from indoor_explorers.learners.pockets.maps import map_files, map_record
from indoor_explorers.learners.pockets.training import NAME, PocketTraining, TrainingConfig
from indoor_explorers.learners.pockets.validation import as_table, judge
from indoor_explorers.learners.sessions.session import Session
from indoor_explorers.learners.sessions.tensorboard import Scalars
from indoor_explorers.learners.sessions.train import TrainingMethod

__all__ = ["DEFAULT_SCENARIO", "TrainingConfig", "train"]

#: There is none: each flight draws its map and lidar.
DEFAULT_SCENARIO = None


@contextmanager
def _trainee(config: TrainingConfig, scenario: None, seed: int, session: Session) -> Iterator[PocketTraining]:
    with Scalars(session):
        yield PocketTraining(config, seed, session.out, session.checkpoint)
    if "floors" in config.suites:
        table = as_table(judge(map_files("floors", Part.VALIDATION, config.folders), session.out / NAME))
        (session.out / "validation.md").write_text(table, encoding="utf-8")


train = TrainingMethod(partial(map_record, "pockets"), _trainee, weights=NAME)
