"""The thesis network's weights on disk: safetensors in half precision, with the image format as metadata."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.learners.thesis.inference import ThesisWeights, weights_from
from indoor_explorers.learners.thesis.sizes import ImageFormat
from indoor_explorers.planners.toolbox.networks.tensors import read_tensors, write_tensors

#: The weights that ship: 4,000 episodes of training with the thesis's best setting, reward scenario 1 and stuck rule 2.
SHIPPED = Path(__file__).parent / "weights" / "rewards-1-stuck-2.safetensors"
#: Largest size of a weights file; a network for 16x16 cells takes 1.3 MB.
MOST_BYTES = 64_000_000


class TrainedNetwork(NamedTuple):
    """A network arranged for acting."""

    image_format: ImageFormat
    weights: ThesisWeights


def write_weights(path: Path, arrays: Mapping[str, NDArray[Any]], image_format: ImageFormat) -> None:
    """Write a network's arrays in half precision, rounded to three digits."""
    halves = {name: array.astype(np.float16) for name, array in arrays.items()}
    write_tensors(path, halves, {"eye": json.dumps(image_format._asdict())})


def load_weights(path: Path) -> tuple[ImageFormat, dict[str, NDArray[np.float32]]]:
    """Return a network's image format and its arrays by name, float32.

    Raises:
        InputError: the file is missing, too large, not a safetensors file, or holds another network.

    """
    found, metadata = read_tensors(path, MOST_BYTES)
    try:
        image_format = ImageFormat(**json.loads(metadata["eye"]))
        expected = image_format.shapes()
    except (KeyError, TypeError, json.JSONDecodeError) as error:
        raise InputError(
            f"{path}: expected weights of the thesis's network, got others; give weights that train --learner "
            "dddqn-thesis wrote"
        ) from error
    if {name: array.shape for name, array in found.items()} != expected:
        raise InputError(f"{path}: expected the arrays of the thesis's network, got others; train again")
    return image_format, {name: array.astype(np.float32) for name, array in found.items()}


def trained(path: Path) -> TrainedNetwork:
    """Return a network arranged for acting; a process reads the file once, and again when it changes.

    Raises:
        InputError: as :func:`load_weights`.

    """
    return _read_once(path, path.stat().st_mtime_ns if path.is_file() else 0)


@lru_cache(maxsize=8)
def _read_once(path: Path, changed: int) -> TrainedNetwork:
    image_format, arrays = load_weights(path)
    return TrainedNetwork(image_format, weights_from(arrays, image_format.view()))
