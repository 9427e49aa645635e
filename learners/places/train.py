"""The dueling network that chooses places, among frontier clusters, on maps of any size.

A training is a session around :class:`indoor_explorers.learners.places.train.PlacesTraining`. It draws its own maps
and tasks, so it takes no scenario. The folder gets ``places.safetensors`` (the mean of the later rounds' networks),
``training.json`` (configuration, seed, versions, commits, figures of each round), ``checkpoint.safetensors``
(everything that a resumed training needs, beside the flights of the present round in ``flights/``) and
``tensorboard/``. The same seed gives the same weights, resumed or not.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Self

import numpy as np
import torch
from pydantic import Field, model_validator

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.provenance import record_of, recorded_maps
from indoor_explorers.env.scenarios.seed_sets import SeedUse
from indoor_explorers.learners.places.flights import choices_of, fly, read_choices, write_choices
from indoor_explorers.learners.places.learning import (
    DUELING_PASSES,
    LATER,
    OPTION_PASSES,
    advantages,
    explained,
    learn_choices,
    learn_values,
)
from indoor_explorers.learners.places.model import AdvantageNet, load_into, weights_of
from indoor_explorers.learners.places.network import (
    WIDTH,
    Loaded,
    OptionWeights,
    Weights,
    grown,
    layout_of,
    load_weights,
    reporting_as,
    write_weights,
)
from indoor_explorers.learners.places.policy import NAME, SHIPPED
from indoor_explorers.learners.pockets.maps import TrainingMaps, map_record
from indoor_explorers.learners.pockets.rounds import RoundSettings, RoundsTraining
from indoor_explorers.learners.reports.network import WIDTH as REPORTS_WIDTH
from indoor_explorers.learners.reports.network import NetworkWeights as ReportsWeights
from indoor_explorers.learners.reports.network import load_weights as load_reports
from indoor_explorers.learners.reports.policy import NAME as REPORTS_NAME
from indoor_explorers.learners.reports.policy import SHIPPED as REPORTS_SHIPPED
from indoor_explorers.learners.sessions.session import Session
from indoor_explorers.learners.sessions.tensorboard import Scalars
from indoor_explorers.learners.sessions.train import TrainingMethod
from indoor_explorers.planners.toolbox.networks.weights_file import optional_weights_path
from indoor_explorers.planners.toolbox.pockets.estimates import EstimateFiles

__all__ = ["DEFAULT_SCENARIO", "SCALING", "SCALING_AXES", "TrainingConfig", "flown", "train"]

#: First round whose network counts in the mean that is flown.
AVERAGED_FROM = 2


class TrainingConfig(RoundSettings):
    """Describe one training completely, together with its seed."""

    rounds: int = Field(3, ge=0)
    """Rounds of flying and learning; with 0, the network is that with which a training begins."""
    prior: float = 0.45
    """Weight of the costs of ``frontier-predictive`` in the value of a place; 0 begins without that planner."""
    guess: bool = True
    """Show the network the estimates of the free space behind the clusters."""
    others: bool = True
    """Show the network the other places beside each place."""
    lookouts: int = Field(0, ge=0, le=64)
    """Most places near the UAV that need not be at a frontier, see ``frontier-predictive``."""
    width: int = Field(WIDTH, ge=8, le=4096)
    """Units of each hidden layer."""
    harder_tasks: float = Field(0.0, ge=0.0, le=1.0)
    """Share of the flights over one level in harder tasks: narrow views, errors of sensors and poses, failures."""
    task_inputs: bool = False
    """Show the network what is harder about the task, and where teammates fly."""
    bases: float = Field(0.0, ge=0.0, le=1.0)
    """Share of the flights over one level with a home base and a deadline."""
    options: bool = False
    """Let the network choose between places, reports to a base, staying as a relay, and loop closures."""
    options_alone: bool = False
    """Let only the options learn: places keep the values of the initial weights, and the best one is flown to."""
    initial_weights: str | None = None
    """Path of a training's folder, or of weights, to begin with, or ``shipped`` for the shipped ones. None: none, the
    network begins as the planner."""
    initial_reports: str | None = None
    """The same for the weights of ``dddqn-reports`` by which reports are valued at first; None: by a rule alone."""
    levels: float = Field(0.0, ge=0.0, le=1.0)
    """Share of the flights in generated buildings of several levels."""
    pocket_weights: str | None = None
    """Path of a training's folder, or of weights, of the network that estimates pockets; None: the shipped ones."""
    level_weights: str | None = None
    """The same for maps of several levels, or ``shipped`` for the shipped ones; None: there are no estimates there."""

    @property
    def estimate_files(self) -> EstimateFiles:
        """The files of the weights of the estimates."""
        return EstimateFiles.named(self.pocket_weights, self.level_weights)

    @model_validator(mode="after")
    def _are_weights(self) -> Self:
        _ = self.estimate_files, self.initial, self.reports
        if self.options_alone and not self.options:
            raise InputError("options_alone: expected options=true with it; set it, or leave options_alone away")
        return self

    @property
    def initial(self) -> Loaded | None:
        """The weights that the training begins with, if any.

        Raises :class:`InputError` where they are missing or of a network with other settings.
        """
        path = self._initial_path
        if path is None:
            return None
        loaded = load_weights(path)
        asked = {"prior": self.prior, "guess": self.guess, "others": self.others, "width": self.width}
        found = {name: getattr(loaded, name) for name in asked}
        inputs, seen = (self.task_inputs, self.options), (loaded.task, loaded.options)
        if found != asked or not (seen == inputs or (loaded.task <= self.task_inputs and not loaded.options)):
            raise InputError(
                f"{path}: expected weights of a network with {asked}, task inputs {inputs[0]} and options {inputs[1]}, "
                f"got {found}, {seen[0]} and {seen[1]}; give the training these settings, or other weights"
            )
        return loaded

    @property
    def reports(self) -> ReportsWeights | None:
        """The weights by which reports are valued at first, if any.

        Raises :class:`InputError` where they are missing, or this network has no options or is narrower.
        """
        path = self._reports_path
        if path is None:
            return None
        if not self.options or self.width < REPORTS_WIDTH:
            raise InputError(
                f"initial_reports: expected options=true and width >= {REPORTS_WIDTH}, got options "
                f"{str(self.options).lower()} and width {self.width}; set them, or leave initial_reports away"
            )
        return load_reports(path)

    @property
    def _initial_path(self) -> Path | None:
        return optional_weights_path(self.initial_weights, SHIPPED, NAME)

    @property
    def _reports_path(self) -> Path | None:
        return optional_weights_path(self.initial_reports, REPORTS_SHIPPED, REPORTS_NAME)

    def seen_maps(self) -> tuple[str, ...]:
        """Return what is learned from, and what the initial weights were learned from."""
        seen = list(super().seen_maps())
        for path in filter(None, (self._initial_path, self._reports_path)):
            seen += recorded_maps(record_of(path)).get(SeedUse.TRAINING, [])
        return tuple(dict.fromkeys(seen))

    def maps(self) -> TrainingMaps:
        """Return the training maps, with buildings of several levels among them."""
        return replace(super().maps(), levels=self.levels)


def fly_seeds(maps: TrainingMaps, loaded: Loaded, config: TrainingConfig, path: Path, seeds: range) -> None:
    """Fly a network, a flight for each seed, and write the choices to a file."""
    settings = config.estimate_files, config.harder_tasks, config.bases, config.options_alone
    write_choices(path, choices_of([fly(maps, seed, loaded, *settings) for seed in seeds]))


class PlacesTraining(RoundsTraining[TrainingConfig, Weights]):
    """Alternate flights and learning."""

    @property
    def layout(self) -> type[Any]:
        """The named tuple of the network's arrays."""
        return layout_of(self.config.options)

    def untrained(self) -> Weights:
        """Return the initial weights, or those of a network that leaves the values to planners and rules."""
        torch.manual_seed(self.seed)
        network, initial, reports = weights_of(self._network()), self.config.initial, self.config.reports
        if initial is not None:
            network = grown(initial, network, self.config.task_inputs)
        if reports is not None and isinstance(network, OptionWeights):
            network = reporting_as(reports, network)
        return network

    def flying(self) -> Callable[[Path, range], None]:
        """Return the function that flies the latest network."""
        return partial(fly_seeds, self.maps, self._loaded(self.networks[-1]), self.config)

    def learned(self, paths: Sequence[Path]) -> tuple[Weights, dict[str, int | float]]:
        """Return the next network, and figures of the round."""
        torch.manual_seed(1000 * self.seed + self.rounds)
        choices = read_choices(paths)
        values = learn_values(choices)
        network, passes = self._network(), DUELING_PASSES
        load_into(network, self.networks[-1])
        if self.config.options_alone:
            network.keep_places()
            passes = OPTION_PASSES
        error = learn_choices(network, choices, advantages(choices, values, LATER), passes)
        t90, t99 = np.nanmean(choices.times, axis=0).tolist()
        means = {"t90": t90, "t99": t99, "explained": explained(choices, values), "error": error}
        figures = {"choices": len(values)} | {name: round(value, 4) for name, value in means.items()}
        return weights_of(network), figures

    def mean(self) -> Loaded:
        """Return the network that is flown, whatever the rounds' figures: the mean of the weights of the later rounds.

        A mean of weights along one training is steadier than the last ones (Izmailov et al. 2018, "Averaging Weights
        Leads to Wider Optima and Better Generalization", arXiv:1803.05407).
        """
        layers = zip(*self.networks[min(AVERAGED_FROM, self.rounds) :], strict=True)
        return self._loaded(self.layout(*(np.mean(layer, axis=0) for layer in layers)))

    def _loaded(self, weights: Weights) -> Loaded:
        config = self.config
        settings = config.prior, config.guess, config.others, config.lookouts, config.task_inputs, config.options
        return Loaded(weights, *settings)

    def _network(self) -> AdvantageNet:
        config = self.config
        return AdvantageNet(config.width, config.task_inputs, config.options, config.prior)

    def write(self, folder: Path) -> None:
        """Write the network that is flown."""
        write_weights(folder / NAME, self.mean())


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
