"""The dueling network that chooses places, among frontier clusters, on maps of any size.

A training is a session around :class:`indoor_explorers.learners.places.train.PlacesTraining`. It draws its own maps
and tasks, so it takes no scenario. The folder gets ``places.safetensors`` (the mean of the later rounds' networks),
``training.json`` (configuration, seed, versions, commits, figures of each round), ``checkpoint.safetensors``
(everything that a resumed training needs, beside the flights of the present round in ``flights/``) and
``tensorboard/``. The same seed gives the same weights, resumed or not.
"""

from __future__ import annotations

import math
import multiprocessing
import shutil
import signal
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from pydantic import Field

from indoor_explorers.learners.places.flights import choices_of, fly, read_choices, write_choices
from indoor_explorers.learners.places.learning import LATER, advantages, explained, learn_choices, learn_values
from indoor_explorers.learners.places.model import AdvantageNet, load_into, weights_of
from indoor_explorers.learners.places.network import WIDTH, Loaded, NetworkWeights, write_weights
from indoor_explorers.learners.places.policy import NAME
from indoor_explorers.learners.pockets.maps import FLIGHTS, MapSettings, TrainingMaps, map_record
from indoor_explorers.learners.sessions.checkpoint import read_checkpoint, reporting_damage, write_checkpoint
from indoor_explorers.learners.sessions.session import Session, Trainee, TrainingStatus
from indoor_explorers.learners.sessions.tensorboard import Scalars
from indoor_explorers.learners.sessions.train import TrainingMethod

__all__ = ["DEFAULT_SCENARIO", "SCALING", "SCALING_AXES", "TrainingConfig", "flown", "train"]

#: Flights in one file; a Ctrl-C waits for the file that is ready next.
TOGETHER = 5
#: Distance between the first flight seeds of two rounds, and of two trainings.
ROUND_SEEDS, TRAINING_SEEDS = 100_000, 10_000_000
#: First round whose network counts in the mean that is flown.
AVERAGED_FROM = 2


class TrainingConfig(MapSettings):
    """Describe one training completely, together with its seed."""

    rounds: int = Field(3, ge=1)
    """Rounds of flying and learning."""
    flights: int = Field(800, ge=1)
    """Flights in one round."""
    prior: float = 0.45
    """Weight of the costs of ``frontier-predictive`` in the value of a place; 0 begins without that planner."""
    guess: bool = True
    """Show the network the estimates of the free space behind the clusters."""
    others: bool = True
    """Show the network the other places beside each place."""
    width: int = Field(WIDTH, ge=8, le=4096)
    """Units of each hidden layer."""
    workers: int = Field(2, ge=1, exclude=True)
    """Processes that fly; the weights do not depend on it."""
    evaluation_every: int = Field(1, ge=1)
    """Rounds between two entries of the record."""
    checkpoint_every: int = Field(1, ge=1)
    """Rounds between two checkpoints."""


class FlightsFile(NamedTuple):
    """Some flights of a round, which one file holds."""

    path: Path
    seeds: range
    """A seed for each flight."""
    maps: TrainingMaps
    loaded: Loaded
    """The network that flies."""


def fly_file(part: FlightsFile) -> int:
    """Fly and write a file of flights, unless it exists; return the number of flights."""
    if not part.path.exists():
        part.path.parent.mkdir(parents=True, exist_ok=True)
        write_choices(part.path, choices_of([fly(part.maps, seed, part.loaded) for seed in part.seeds]))
    return len(part.seeds)


class PlacesTraining(Trainee):
    """Alternate flights, in processes of their own, and learning; a Ctrl-C takes effect after the next file of flights.

    Flights of a round stay in ``folder`` until a checkpoint holds the network that was learned from them.
    """

    unit = "rounds"
    steps = 0

    def __init__(self, config: TrainingConfig, seed: int, folder: Path, checkpoint: Path | None = None) -> None:
        self.config, self.seed, self.folder = config, seed, folder / FLIGHTS
        self.maps = config.maps()
        self.figures: dict[str, int | float] = {}
        """Figures of the latest round."""
        if checkpoint is None:
            shutil.rmtree(self.folder, ignore_errors=True)  # of a training that was killed before its first checkpoint
            torch.manual_seed(seed)
            self.networks = [weights_of(AdvantageNet(config.width))]
            """The untrained network, and that after each round."""
        else:
            self._restore(checkpoint)
        self.steps = self.rounds * config.flights

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
                self._learn([part.path for part in parts])
                session.after_update(self)

    def _parts(self) -> list[FlightsFile]:
        first = TRAINING_SEEDS * (1 + self.seed) + ROUND_SEEDS * self.rounds
        seeds, loaded = range(first, first + self.config.flights), self._loaded(self.networks[-1])
        return [
            FlightsFile(self.folder / f"{self.rounds}/{k}.safetensors", seeds[k : k + TOGETHER], self.maps, loaded)
            for k in range(0, len(seeds), TOGETHER)
        ]

    def _learn(self, paths: Sequence[Path]) -> None:
        """Learn the next network from the flights of a round."""
        torch.manual_seed(1000 * self.seed + self.rounds)
        choices = read_choices(paths)
        values = learn_values(choices)
        network = AdvantageNet(self.config.width)
        load_into(network, self.networks[-1])
        error = learn_choices(network, choices, advantages(choices, values, LATER))
        self.networks.append(weights_of(network))
        t90, t99 = np.nanmean(choices.times, axis=0).tolist()
        means = {"t90": t90, "t99": t99, "explained": explained(choices, values), "error": error}
        self.figures = {"rounds": self.rounds, "choices": len(values)}
        self.figures |= {name: round(value, 4) for name, value in means.items()}

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

    def mean(self) -> Loaded:
        """Return the network that is flown, whatever the rounds' figures: the mean of the weights of the later rounds.

        A mean of weights along one training is steadier than the last ones (Izmailov et al. 2018, "Averaging Weights
        Leads to Wider Optima and Better Generalization", arXiv:1803.05407).
        """
        layers = zip(*self.networks[min(AVERAGED_FROM, self.rounds) :], strict=True)
        return self._loaded(NetworkWeights(*(np.mean(layer, axis=0) for layer in layers)))

    def _loaded(self, weights: NetworkWeights) -> Loaded:
        return Loaded(weights, self.config.prior, self.config.guess, self.config.others)

    def save(self, folder: Path) -> None:
        """Write the checkpoint and the network that is flown; delete the flights that were learned from."""
        tensors = {
            f"{number}/{name}": array
            for number, weights in enumerate(self.networks)
            for name, array in weights._asdict().items()
        }
        write_checkpoint(folder, tensors, {"rounds": self.rounds, "figures": self.figures})
        write_weights(folder / NAME, self.mean())
        for number in range(self.rounds):
            shutil.rmtree(self.folder / str(number), ignore_errors=True)

    def _restore(self, path: Path) -> None:
        tensors, state = read_checkpoint(path)
        with reporting_damage(path):
            self.networks = [
                NetworkWeights(*(tensors[f"{number}/{name}"] for name in NetworkWeights._fields))
                for number in range(state["rounds"] + 1)
            ]
            self.figures = state["figures"]


#: There is none: each flight draws its map, lidar, team and radio.
DEFAULT_SCENARIO = None

#: Settings of the trainings of the scaling study, by name: three rounds of so many flights.
SCALING: Mapping[str, Mapping[str, Any]] = {
    **{f"flights-{3 * flights}": {"flights": flights} for flights in (12, 50, 200, 800)},
    **{f"width-{width}": {"flights": 200, "width": width} for width in (16, 256)},
    **{f"maps-{maps}": {"flights": 200, "map_count": maps} for maps in (8, 64)},
}

#: Its axes: names of trainings by level.
SCALING_AXES: Mapping[str, Mapping[float, str]] = {
    "flights in training": {flights: f"flights-{flights}" for flights in (36, 150, 600, 2400)},
    "units of a hidden layer": {16: "width-16", WIDTH: "flights-600", 256: "width-256"},
    "maps in training": {8: "maps-8", 64: "maps-64", math.inf: "flights-600"},
}


def flown(weights: Path) -> dict[str, Any]:
    """Return the policy, as in an experiment file, that flies trained weights."""
    return {"use": "dddqn-places", "parameters": {"weights": str(weights.resolve())}}


@contextmanager
def _trainee(config: TrainingConfig, scenario: None, seed: int, session: Session) -> Iterator[PlacesTraining]:
    with Scalars(session):
        yield PlacesTraining(config, seed, session.out, session.checkpoint)


train = TrainingMethod(partial(map_record, "dddqn-places"), _trainee, weights=NAME)
