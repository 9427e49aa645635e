"""The dueling network that chooses when to report to a home base.

A training is a session around :class:`ReportsTraining`. It draws its own maps and tasks, so it takes no scenario. The
folder gets ``reports.safetensors`` (the latest round's network), ``training.json``, ``checkpoint.safetensors`` and
``tensorboard/``. The same seed gives the same weights, resumed or not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import torch
from pydantic import Field, field_validator

from indoor_explorers.env.policies.registry import make_policy
from indoor_explorers.learners.pockets.maps import TrainingMaps, map_record
from indoor_explorers.learners.pockets.rounds import RoundSettings, RoundsTraining
from indoor_explorers.learners.reports.flights import fly, joined, read_choices, write_choices
from indoor_explorers.learners.reports.learning import (
    LATER,
    AdvantageNet,
    advantages,
    explained,
    learn_choices,
    learn_values,
)
from indoor_explorers.learners.reports.network import NetworkWeights, write_weights
from indoor_explorers.learners.reports.policy import NAME
from indoor_explorers.learners.sessions.session import Session
from indoor_explorers.learners.sessions.tensorboard import Scalars
from indoor_explorers.learners.sessions.train import TrainingMethod

__all__ = ["DEFAULT_SCENARIO", "TrainingConfig", "flown", "train"]


class TrainingConfig(RoundSettings):
    """Describe one training completely, together with its seed."""

    rounds: int = Field(5, ge=1)
    """Rounds of flying and learning."""
    flights: int = Field(1000, ge=1)
    """Flights in one round."""
    explorer: str = "frontier-predictive"
    """Registry name of the policy that explores."""
    clear: float = Field(3.5, gt=0)
    """Largest value by which choices are drawn in the first round: see :func:`~.flights.fly`, and"""
    clearer: float = Field(1.0, ge=0)
    """by how much it grows in each later round, so that choices are less and less random."""

    @field_validator("explorer")
    @classmethod
    def _exists(cls, explorer: str) -> str:
        make_policy(explorer)
        return explorer


def fly_seeds(
    maps: TrainingMaps, explorer: str, weights: NetworkWeights, clear: float, path: Path, seeds: range
) -> None:
    """Fly a network, a flight for each seed, and write the choices to a file."""
    write_choices(path, joined([fly(maps, explorer, weights, clear, seed) for seed in seeds]))


class ReportsTraining(RoundsTraining[TrainingConfig, NetworkWeights]):
    """Alternate flights and learning."""

    layout = NetworkWeights

    def untrained(self) -> NetworkWeights:
        """Return a network that leaves the choice to the rule."""
        torch.manual_seed(self.seed)
        return AdvantageNet().weights()

    def flying(self) -> Callable[[Path, range], None]:
        """Return the function that flies the latest network."""
        clear = self.config.clear + self.rounds * self.config.clearer
        return partial(fly_seeds, self.maps, self.config.explorer, self.networks[-1], clear)

    def learned(self, paths: Sequence[Path]) -> tuple[NetworkWeights, dict[str, int | float]]:
        """Return the next network, and figures of the round."""
        torch.manual_seed(1000 * self.seed + self.rounds)
        choices = read_choices(paths)
        values = learn_values(choices)
        network = AdvantageNet()
        network.load(self.networks[-1])
        error = learn_choices(network, choices, advantages(choices, values, LATER))
        coverage, enough = choices.results.mean(axis=0).tolist()
        means = {"auc_base": coverage, "reported": enough, "explained": explained(choices, values), "error": error}
        figures = {"choices": len(values)} | {name: round(value, 4) for name, value in means.items()}
        return network.weights(), figures

    def write(self, folder: Path) -> None:
        """Write the network that is flown."""
        write_weights(folder / NAME, self.networks[-1])


#: There is none: each flight draws its map, lidar, team, radio and deadline.
DEFAULT_SCENARIO = None


def flown(weights: Path) -> dict[str, Any]:
    """Return the policy, as in an experiment file, that flies trained weights."""
    return {"use": "dddqn-reports", "parameters": {"weights": str(weights.resolve())}}


@contextmanager
def _trainee(config: TrainingConfig, scenario: None, seed: int, session: Session) -> Iterator[ReportsTraining]:
    with Scalars(session):
        yield ReportsTraining(config, seed, session.out, session.checkpoint)


train = TrainingMethod(partial(map_record, "dddqn-reports"), _trainee, weights=NAME)
