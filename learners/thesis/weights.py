"""The thesis network's weights on disk: in half precision, with its image format."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.learners.thesis.inference import ThesisWeights, weights_from
from indoor_explorers.learners.thesis.sizes import ImageFormat
from indoor_explorers.planners.toolbox.networks.weights_file import (
    read_once,
    read_weights_file,
    write_weights_file,
)

#: The weights that ship: 4,000 episodes of training with the thesis's best setting, reward scenario 1 and stuck rule 2.
SHIPPED = Path(__file__).parent / "weights" / "rewards-1-stuck-2.safetensors"


class TrainedNetwork(NamedTuple):
    """A network arranged for acting."""

    image_format: ImageFormat
    weights: ThesisWeights


def write_weights(path: Path, arrays: Mapping[str, NDArray[Any]], image_format: ImageFormat) -> None:
    """Write a network's arrays, shaped as ``image_format.shapes()``, in half precision, rounded to three digits."""
    write_weights_file(path, arrays, image_format._asdict(), half=True)


def load_weights(path: Path) -> tuple[ImageFormat, dict[str, NDArray[np.float32]]]:
    """Return a network's image format and its arrays by name, as torch stores them, float32.

    Raises:
        InputError: the file is missing, too large, not a safetensors file, or holds another network.

    """
    file = read_weights_file(path, "dddqn-thesis")
    image_format, shapes = file.described(_image_format)
    return image_format, file.checked(shapes)


def _image_format(about: Mapping[str, Any]) -> tuple[ImageFormat, dict[str, tuple[int, ...]]]:
    image_format = ImageFormat(**about)
    return image_format, image_format.shapes()


@read_once
def trained(path: Path) -> TrainedNetwork:
    """Return a network arranged for acting; a process reads the file once, and again when it changes.

    Raises:
        InputError: as :func:`load_weights`.

    """
    image_format, arrays = load_weights(path)
    return TrainedNetwork(image_format, weights_from(arrays, image_format.view()))
