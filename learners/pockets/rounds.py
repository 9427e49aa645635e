"""Trainings in rounds: flights in processes of their own, and then learning from all flights of the round."""

from __future__ import annotations

import multiprocessing
import shutil
import signal
from abc import abstractmethod
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from pydantic import Field

from indoor_explorers.learners.pockets.maps import FLIGHTS, MapSettings
from indoor_explorers.learners.sessions.checkpoint import read_checkpoint, reporting_damage, write_checkpoint
from indoor_explorers.learners.sessions.session import Session, Trainee, TrainingStatus

#: Flights in one file; a Ctrl-C waits for the file that is ready next.
TOGETHER = 5
#: Distance between the first flight seeds of two rounds, and of two trainings.
ROUND_SEEDS, TRAINING_SEEDS = 100_000, 10_000_000


class RoundSettings(MapSettings):
    """The settings of a training in rounds."""

    rounds: int = Field(3, ge=1)
    """Rounds of flying and learning."""
    flights: int = Field(800, ge=1)
    """Flights in one round."""
    workers: int = Field(2, ge=1, exclude=True)
    """Processes that fly; the weights do not depend on it."""
    evaluation_every: int = Field(1, ge=1)
    """Rounds between two entries of the record."""
    checkpoint_every: int = Field(1, ge=1)
    """Rounds between two checkpoints."""


Settings = TypeVar("Settings", bound=RoundSettings)
#: A named tuple of a network's arrays.
Weights = TypeVar("Weights", bound=tuple[np.ndarray, ...])


class FlightsFile(NamedTuple):
    """Some flights of a round, which one file holds."""

    path: Path
    seeds: range
    """A seed for each flight."""
    fly: Callable[[Path, range], None]
    """Flies them and writes the file; sent to another process."""


def fly_file(part: FlightsFile) -> int:
    """Fly and write a file of flights, unless it exists; return the number of flights."""
    if not part.path.exists():
        part.path.parent.mkdir(parents=True, exist_ok=True)
        part.fly(part.path, part.seeds)
    return len(part.seeds)


class RoundsTraining(Trainee, Generic[Settings, Weights]):
    """Alternate flights, in processes of their own, and learning; a Ctrl-C takes effect after the next file of flights.

    Flights of a round stay in ``folder`` until a checkpoint holds the network that was learned from them.
    """

    unit = "rounds"
    steps = 0

    def __init__(self, config: Settings, seed: int, folder: Path, checkpoint: Path | None = None) -> None:
        self.config, self.seed, self.folder = config, seed, folder / FLIGHTS
        self.maps = config.maps()
        self.figures: dict[str, int | float] = {}
        """Figures of the latest round."""
        if checkpoint is None:
            shutil.rmtree(self.folder, ignore_errors=True)  # of a training that was killed before its first checkpoint
            self.networks: list[Weights] = [self.untrained()]
            """The untrained network, and that after each round."""
        else:
            self._restore(checkpoint)
        self.steps = self.rounds * config.flights

    @property
    @abstractmethod
    def layout(self) -> type[Any]:
        """The named tuple of a network's arrays."""

    @abstractmethod
    def untrained(self) -> Weights:
        """Return the network that flies first, which depends on the seed alone."""

    @abstractmethod
    def flying(self) -> Callable[[Path, range], None]:
        """Return the function that flies seeds by the latest network and writes them to a file."""

    @abstractmethod
    def learned(self, paths: Sequence[Path]) -> tuple[Weights, dict[str, int | float]]:
        """Return the next network, learned from files of flights, and figures of the round."""

    @abstractmethod
    def write(self, folder: Path) -> None:
        """Write the network that is flown."""

    @property
    def rounds(self) -> int:
        """Finished rounds."""
        return len(self.networks) - 1

    @property
    def done(self) -> bool:
        """Tell whether the training is complete."""
        return self.rounds >= self.config.rounds

    def train(self, session: Session) -> None:
        """Fly and learn until :attr:`done` or until a Ctrl-C, which the flying processes leave to this one."""
        if session.checkpoint is None:
            session.write(self)  # flights belong to a record
        with multiprocessing.get_context("spawn").Pool(
            self.config.workers, signal.signal, (signal.SIGINT, signal.SIG_IGN)
        ) as pool:
            while not self.done:
                parts = self._parts()
                for count in pool.imap_unordered(fly_file, parts):
                    self.steps += count
                    session.report(self)
                    if session.interrupted:
                        return
                network, figures = self.learned([part.path for part in parts])
                self.networks.append(network)
                self.figures = {"rounds": self.rounds, **figures}
                session.after_update(self)

    def _parts(self) -> list[FlightsFile]:
        first = TRAINING_SEEDS * (1 + self.seed) + ROUND_SEEDS * self.rounds
        seeds, fly = range(first, first + self.config.flights), self.flying()
        return [
            FlightsFile(self.folder / f"{self.rounds}/{k}.safetensors", seeds[k : k + TOGETHER], fly)
            for k in range(0, len(seeds), TOGETHER)
        ]

    def status(self) -> TrainingStatus:
        """Return the current status; the loss is that of the latest round."""
        total = self.config.rounds * self.config.flights
        return TrainingStatus(total_steps=total, counted="flights", loss=self.figures.get("error", np.nan))

    def evaluate(self) -> dict[str, int | float]:
        """Return the figures of the latest round's flights, which are over training maps, with random choices."""
        return self.figures

    def results(self) -> dict[str, Any]:
        """Return the number of map files."""
        return {"files": len(self.maps.paths)}

    def save(self, folder: Path) -> None:
        """Write the checkpoint and the network that is flown; delete the flights that were learned from."""
        tensors = {
            f"{number}/{name}": array
            for number, weights in enumerate(self.networks)
            for name, array in weights._asdict().items()  # type: ignore[attr-defined]
        }
        write_checkpoint(folder, tensors, {"rounds": self.rounds, "figures": self.figures})
        self.write(folder)
        for number in range(self.rounds):
            shutil.rmtree(self.folder / str(number), ignore_errors=True)

    def _restore(self, path: Path) -> None:
        tensors, state = read_checkpoint(path)
        with reporting_damage(path):
            self.networks = [
                self.layout(*(tensors[f"{number}/{name}"] for name in self.layout._fields))
                for number in range(state["rounds"] + 1)
            ]
            self.figures = state["figures"]
