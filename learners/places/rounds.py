"""The rounds of a training, resumable from its folder."""

from __future__ import annotations

import multiprocessing
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch

from indoor_explorers.learners.places.choices import choices_of, read_choices, write_choices
from indoor_explorers.learners.places.flights import fly
from indoor_explorers.learners.places.model import AdvantageNet, load_into, weights_of
from indoor_explorers.learners.places.network import Loaded, NetworkWeights, load_weights, write_weights
from indoor_explorers.learners.places.train import LATER, advantages, explained, learn_choices, learn_values
from indoor_explorers.learners.pockets.maps import TrainingMaps

#: Flights of one file.
TOGETHER = 20
#: Seeds between the flights of two rounds, and of two trainings.
ROUND_SEEDS, TRAINING_SEEDS = 100_000, 10_000_000
#: First round whose network counts in the mean that is flown.
AVERAGED_FROM = 2


@dataclass(frozen=True, kw_only=True)
class Training:
    """A training and its folder."""

    folder: Path
    maps: TrainingMaps
    flights: int
    """Flights of a round."""
    rounds: int
    seed: int
    prior: float
    guess: bool
    others: bool
    workers: int

    def weights(self, number: int) -> Path:
        """Return the path of the network after ``number`` rounds."""
        return self.folder / f"round-{number}.safetensors"

    def run(self, tell: Callable[[str], None]) -> Iterator[dict[str, Any]]:
        """Train; yield the figures of each round that was not there before."""
        if not self.weights(0).exists():
            torch.manual_seed(self.seed)
            first = weights_of(AdvantageNet())
            write_weights(self.weights(0), Loaded(first, self.prior, self.guess, self.others))
        with multiprocessing.get_context("spawn").Pool(self.workers) as pool:
            for number in range(self.rounds):
                if self.weights(number + 1).exists():
                    continue
                parts = self._parts(number)
                for k, _ in enumerate(pool.imap_unordered(fly_part, parts), start=1):
                    if k % 10 == 0 or k == len(parts):
                        tell(f"round {number + 1} of {self.rounds}: {min(k * TOGETHER, self.flights)} flights")
                yield {"round": number + 1} | self._learn(number, [part.path for part in parts])

    def mean(self) -> Loaded:
        """Return the network whose weights are the means of those of the later rounds.

        A mean of weights along one training is steadier than the last ones (Izmailov et al. 2018, "Averaging Weights
        Leads to Wider Optima and Better Generalization", arXiv:1803.05407).
        """
        counted = range(min(AVERAGED_FROM, self.rounds), self.rounds + 1)
        networks = [load_weights(self.weights(number)) for number in counted]
        layers = zip(*(each.weights for each in networks), strict=True)
        return networks[0]._replace(weights=NetworkWeights(*(np.mean(layer, axis=0) for layer in layers)))

    def _parts(self, number: int) -> list[Part]:
        first = TRAINING_SEEDS * (1 + self.seed) + ROUND_SEEDS * number
        return [
            Part(
                path=self.folder / f"round-{number}" / f"{k}.safetensors",
                seeds=range(first + k, first + min(k + TOGETHER, self.flights)),
                maps=self.maps,
                weights=self.weights(number),
            )
            for k in range(0, self.flights, TOGETHER)
        ]

    def _learn(self, number: int, paths: list[Path]) -> dict[str, float]:
        """Learn from a round's flights, and write the network; return what there is to tell of the round."""
        torch.manual_seed(1000 * self.seed + number)
        choices, loaded = read_choices(paths), load_weights(self.weights(number))
        values = learn_values(choices)
        network = AdvantageNet()
        load_into(network, loaded.weights)
        error = learn_choices(network, choices, advantages(choices, values, LATER))
        write_weights(self.weights(number + 1), loaded._replace(weights=weights_of(network)))
        shutil.rmtree(paths[0].parent)
        t90, t99 = np.nanmean(choices.times, axis=0).tolist()
        about = {"choices": len(values), "t90": t90, "t99": t99, "explained": explained(choices, values)}
        return {name: round(value, 4) for name, value in (about | {"error": error}).items()}


class Part(NamedTuple):
    """Some flights of a round, which are written to one file."""

    path: Path
    seeds: range
    maps: TrainingMaps
    weights: Path
    """The network that flies."""


def fly_part(part: Part) -> None:
    """Fly and write some flights, unless their file is there."""
    if part.path.exists():
        return
    part.path.parent.mkdir(exist_ok=True)
    loaded = load_weights(part.weights)
    flights = [fly(part.maps, seed, loaded) for seed in part.seeds]
    write_choices(part.path, choices_of(flights))
