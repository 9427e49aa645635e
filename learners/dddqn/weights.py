"""Weights on disk: a weights file also describes its observation and network, so a policy needs only the file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.learners.dddqn.network.config import NetworkConfig
from indoor_explorers.learners.dddqn.network.inference import NetworkWeights, shapes, weights_from
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import ObservationLayout, observation_layout
from indoor_explorers.learners.dddqn.observation.map_prior import prior_shapes
from indoor_explorers.planners.toolbox.networks.weights_file import read_once, read_weights_file, write_weights_file

#: Version of the description and of the inputs; raised when older files can no longer be read.
FORMAT = 2
_FOLDER = Path(__file__).parent / "weights"


class LoadedWeights(NamedTuple):
    """The content of a weights file."""

    observation: ObservationConfig
    network: NetworkConfig
    layout: ObservationLayout
    weights: NetworkWeights
    prior: dict[str, NDArray[np.float32]]
    """The map prior's arrays by name; empty if the observation has no prior."""


def shipped() -> dict[str, Path]:
    """Return the weights that ship, by name."""
    return {path.stem: path for path in sorted(_FOLDER.glob("*.safetensors"))}


def write_weights(
    path: Path,
    network_arrays: Mapping[str, NDArray[np.float32]],
    prior_arrays: Mapping[str, NDArray[np.float32]],
    observation: ObservationConfig,
    network: NetworkConfig,
    *,
    half: bool = False,
) -> None:
    """Write a network and its map prior with their description.

    ``half`` stores float16: half the size, values rounded to three digits.
    """
    about = {"format": FORMAT, "observation": observation.model_dump(mode="json"), "network": network.model_dump()}
    write_weights_file(path, {**network_arrays, **prior_arrays}, about, half=half)


@read_once
def load_weights(path: Path) -> LoadedWeights:
    """Return the content of a weights file; a process reads the file once, and again when it changes.

    Raises :class:`InputError` if the file is missing, too large, not a safetensors file, or holds another network.
    """
    file = read_weights_file(path, "dddqn")
    observation, network = file.described(_configurations)
    layout, prior = observation_layout(observation), prior_shapes(file.arrays)
    arrays = file.checked(shapes(layout, network) | prior)
    weights = weights_from(arrays, layout, network)
    return LoadedWeights(observation, network, layout, weights, {name: arrays[name] for name in prior})


def _configurations(about: Mapping[str, Any]) -> tuple[ObservationConfig, NetworkConfig]:
    if about["format"] != FORMAT:
        raise ValueError(f"format {about['format']!r} instead of {FORMAT}")
    return ObservationConfig.model_validate(about["observation"]), NetworkConfig.model_validate(about["network"])
