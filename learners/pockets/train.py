"""The pocket network, which estimates how much unknown free space is behind each frontier cluster.

A training is a session around :class:`indoor_explorers.learners.pockets.train.PocketTraining`. It flies planners
over maps that it draws, so it takes no scenario. The folder gets ``pockets.safetensors`` (the latest network),
``training.json`` (configuration, seed, versions, commits, loss of each epoch), ``checkpoint.safetensors`` (everything
that a resumed training needs, beside the flights in ``flights/``), ``tensorboard/`` and, with suites or levels,
``validation.md`` (how good the estimates are on validation parts). The same seed gives the same weights, resumed
or not.
"""

from __future__ import annotations

import math
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import Field, model_validator

from indoor_explorers.env.files import write_whole
from indoor_explorers.env.scenarios.suites.suite import Part
from indoor_explorers.learners.pockets.examples import chosen_examples, read_examples, write_examples
from indoor_explorers.learners.pockets.learning import PocketLearner
from indoor_explorers.learners.pockets.maps import FLIGHTS, MapSettings, TrainingMaps, map_files, map_record
from indoor_explorers.learners.pockets.validation import as_table, judge, over_files, over_levels
from indoor_explorers.learners.sessions.checkpoint import read_checkpoint, reporting_damage, write_checkpoint
from indoor_explorers.learners.sessions.networks import network_arrays
from indoor_explorers.learners.sessions.session import Session, Trainee, TrainingStatus
from indoor_explorers.learners.sessions.tensorboard import Scalars
from indoor_explorers.learners.sessions.train import TrainingMethod
from indoor_explorers.planners.toolbox.networks.weights_file import write_weights_file
from indoor_explorers.planners.toolbox.pockets.estimates import NAME
from indoor_explorers.planners.toolbox.pockets.features import LEVELS, PLAIN, Kind

__all__ = ["DEFAULT_SCENARIO", "TrainingConfig", "train"]


class TrainingConfig(MapSettings):
    """Describe one training completely, together with the seed of the network; flights are seeded by their numbers."""

    flights: int = Field(1500, ge=1)
    """Flights to learn from."""
    learn_from: Literal["both", "real", "generated"] = "both"
    """Learn from the flights over map files, from those over generated maps, or from both."""
    levels: bool = False
    """Learn from flights in generated buildings of several levels alone, for estimates there."""
    epochs: int = Field(8, ge=1)
    """Passes over the examples of these flights."""
    evaluation_every: int = Field(1, ge=1)
    """Epochs between two entries of the record."""
    checkpoint_every: int = Field(1, ge=1)
    """Epochs between two checkpoints."""

    @model_validator(mode="after")
    def _have_maps(self) -> Self:
        if self.levels and (self.suites or self.learn_from == "real" or self.halls):
            raise ValueError(
                "expected no suites, no halls and no real maps with levels=true, which has buildings of its own"
            )
        return self

    @property
    def kind(self) -> Kind:
        """The kind of maps that the network sees."""
        return LEVELS if self.levels else PLAIN

    def maps(self) -> TrainingMaps:
        """Return the training maps, or buildings of several levels."""
        return replace(super().maps(), levels=1.0) if self.levels else super().maps()


class PocketTraining(Trainee):
    """Fly, then learn; an update is one flight, whose examples are written to a file, or one batch."""

    unit = "epochs"

    def __init__(self, config: TrainingConfig, seed: int, folder: Path, checkpoint: Path | None = None) -> None:
        self.config, self.seed, self.folder = config, seed, folder / FLIGHTS
        self.maps, self.flown = config.maps(), 0
        self.learner: PocketLearner | None = None
        """None until all flights are flown."""
        if checkpoint is None:
            shutil.rmtree(self.folder, ignore_errors=True)  # of a training that was killed before its first checkpoint
            self.folder.mkdir()
        else:
            self._restore(checkpoint)

    @property
    def epochs(self) -> int:
        """Finished epochs."""
        return 0 if self.learner is None else self.learner.epochs

    @property
    def steps(self) -> int:
        """Flights flown, and flights learned from, once for each epoch."""
        if self.learner is None:
            return self.flown
        passed = self.learner.epochs + self.learner.updates / max(1, self.learner.updates_per_epoch)
        return self.flown + int(self.config.flights * passed)

    @property
    def done(self) -> bool:
        """Tell whether the training is complete."""
        return self.epochs >= self.config.epochs

    def train(self, session: Session) -> None:
        """Train until :attr:`done` or until a Ctrl-C."""
        if session.checkpoint is None:
            session.write(self)  # flights belong to a record
        super().train(session)

    def update(self) -> None:
        """Fly once, unless the file of this flight is there, or learn from one batch."""
        if self.learner is not None:
            self.learner.update()
        elif self.flown < self.config.flights:
            write_examples(self.maps, self._path(self.flown), self.flown)
            self.flown += 1
        else:
            self.learner = self._begin_learning()

    def _path(self, flight: int) -> Path:
        return self.folder / f"{flight}.npz"

    def _begin_learning(self) -> PocketLearner:
        examples = read_examples([self._path(flight) for flight in range(self.config.flights)])
        some = chosen_examples(examples, self.config.learn_from)
        return PocketLearner(some, epochs=self.config.epochs, seed=self.seed, kind=self.config.kind)

    def status(self) -> TrainingStatus:
        """Return the current status; the loss is the mean of the last epoch."""
        total = self.config.flights * (1 + self.config.epochs)
        mean_loss = math.nan if self.learner is None else self.learner.mean_loss
        return TrainingStatus(total_steps=total, counted="flights flown or learned from", loss=mean_loss)

    def evaluate(self) -> dict[str, int | float]:
        """Return the number of epochs and the mean loss of the last one."""
        return {"epochs": self.epochs, "loss": self.status().loss}

    def results(self) -> dict[str, Any]:
        """Return the numbers of map files and of examples."""
        return {"files": len(self.maps.paths), "examples": 0 if self.learner is None else self.learner.count}

    def save(self, folder: Path) -> None:
        """Write the checkpoint and, once learning has begun, the current network."""
        if self.learner is None:
            write_checkpoint(folder, {}, {})
        else:
            write_checkpoint(folder, self.learner.tensors(), self.learner.state())
            write_weights_file(
                folder / NAME, network_arrays(self.learner.network), {"levels": True} if self.config.levels else {}
            )

    def _restore(self, path: Path) -> None:
        tensors, state = read_checkpoint(path)
        if state:
            while self.flown < self.config.flights:
                self.update()  # flies again what was deleted
            self.learner = self._begin_learning()
            with reporting_damage(path):
                self.learner.restore(tensors, state)


#: There is none: each flight draws its map and lidar.
DEFAULT_SCENARIO = None


@contextmanager
def _trainee(config: TrainingConfig, scenario: None, seed: int, session: Session) -> Iterator[PocketTraining]:
    with Scalars(session):
        yield PocketTraining(config, seed, session.out, session.checkpoint)
    if config.levels or config.suites:
        maps = [map_files(name, Part.VALIDATION, config.folders) for name in config.suites]
        flights = over_levels() if config.levels else over_files(maps)
        write_whole(session.out / "validation.md", as_table(judge(flights, session.out / NAME, config.kind)))


train = TrainingMethod(partial(map_record, "pockets"), _trainee, weights=NAME)
