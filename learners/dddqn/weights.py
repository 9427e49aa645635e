"""Weights on disk: a weights file also describes its observation and network, so a policy needs only the file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from indoor_explorers.env.errors import InputError
from indoor_explorers.learners.dddqn.network.config import NetworkConfig
from indoor_explorers.learners.dddqn.network.inference import NetworkWeights, shapes, weights_from
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import ObservationLayout, observation_layout
from indoor_explorers.learners.dddqn.observation.map_prior import INPUTS
from indoor_explorers.planners.toolbox.networks.tensors import read_tensors, write_tensors

#: Version of the file format; raised when older files can no longer be read.
FORMAT = 2
#: Name of the metadata entry with the description.
ABOUT = "about"
#: Largest size of a weights file.
MOST_BYTES = 1_000_000_000
_FOLDER = Path(__file__).parent / "weights"


class Loaded(NamedTuple):
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
    kind = np.float16 if half else np.float32
    tensors = {name: array.astype(kind) for name, array in ({**network_arrays, **prior_arrays}).items()}
    about = {"format": FORMAT, "observation": observation.model_dump(mode="json"), "network": network.model_dump()}
    write_tensors(path, tensors, {ABOUT: json.dumps(about)})  # safetensors orders several arbitrarily


def load_weights(path: Path) -> Loaded:
    """Return the content of a weights file; a process reads the file once, and again when it changes.

    Raises:
        InputError: the file is missing, too large, not a safetensors file, or holds another network.

    """
    return _read_once(path, path.stat().st_mtime_ns if path.is_file() else 0)


@lru_cache(maxsize=8)
def _read_once(path: Path, changed: int) -> Loaded:
    found, metadata = read_tensors(path, MOST_BYTES)
    observation, network = _described(path, metadata)
    layout = observation_layout(observation)
    prior = {name: array for name, array in found.items() if name.startswith("prior.")}
    own = {name: array for name, array in found.items() if name not in prior}
    _refuse_others(path, own, shapes(layout, network))
    if prior:
        _refuse_others(path, prior, _prior_shapes(len(prior.get("prior.hidden_bias", ()))))
    prior = {name: np.ascontiguousarray(array, np.float32) for name, array in prior.items()}
    return Loaded(observation, network, layout, weights_from(own, layout, network), prior)


def _prior_shapes(units: int) -> dict[str, tuple[int, ...]]:
    return {
        "prior.hidden": (INPUTS, units),
        "prior.hidden_bias": (units,),
        "prior.out": (units,),
        "prior.out_bias": (1,),
    }


def _described(path: Path, metadata: dict[str, str]) -> tuple[ObservationConfig, NetworkConfig]:
    try:
        about = json.loads(metadata.get(ABOUT, "{}"))
        if about.get("format") != FORMAT:
            raise InputError(
                f"{path}: expected weights of format {FORMAT}, got {about.get('format', 'a file without a format')}; "
                "give weights that train wrote, or train again with this version"
            )
        return (
            ObservationConfig.model_validate(about["observation"]),
            NetworkConfig.model_validate(about["network"]),
        )
    except (KeyError, AttributeError, json.JSONDecodeError, ValidationError) as error:
        reason = " ".join(str(error).split())
        raise InputError(
            f"{path}: expected a network that this version knows, got another ({reason}); train again with this version"
        ) from error


def _refuse_others(path: Path, found: Mapping[str, NDArray[Any]], expected: Mapping[str, tuple[int, ...]]) -> None:
    """Raise an error unless ``found`` has exactly these names and shapes."""
    if wrong := sorted(expected.keys() ^ found.keys()):
        raise InputError(
            f"{path}: expected exactly the arrays of the network that it describes, but {wrong[0]!r} is "
            f"{'missing' if wrong[0] in expected else 'unknown'}; give weights that train wrote"
        )
    for name, shape in expected.items():
        if found[name].shape != shape or found[name].dtype.kind != "f":
            raise InputError(
                f"{path}: expected {name!r} to be numbers of shape {shape}, "
                f"got {found[name].dtype} of shape {found[name].shape}; train again with this version"
            )
